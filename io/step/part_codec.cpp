#include "io/step/part_codec.h"

#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "geometry/error.h"

namespace afptraj::step {
namespace {

constexpr std::uint64_t magic = 0x3130504554534641;  // "AFSTEP01"

/// One walk over the model serves both directions: `field(x)` writes x, or reads it.
class Encoder {
 public:
  std::string take() { return std::move(out_); }

  template <class T>
  requires(std::is_arithmetic_v<T> || std::is_enum_v<T>) void field(T& x) {
    out_.append(reinterpret_cast<const char*>(&x), sizeof x);
  }
  void field(std::string& s) { block(s.data(), s.size()); }
  void field(std::vector<double>& v) { block(v.data(), v.size()); }
  void doubles(double* x, std::size_t n) {
    out_.append(reinterpret_cast<const char*>(x), n * sizeof(double));
  }
  template <class T>
  std::size_t size(std::vector<T>& v) {
    auto n = static_cast<std::uint64_t>(v.size());
    field(n);
    return v.size();
  }

 private:
  template <class T>
  void block(const T* data, std::size_t n) {
    auto count = static_cast<std::uint64_t>(n);
    field(count);
    out_.append(reinterpret_cast<const char*>(data), n * sizeof(T));
  }
  std::string out_;
};

class Decoder {
 public:
  explicit Decoder(std::string_view in) : in_(in) {}
  bool at_end() const { return in_.empty(); }

  template <class T>
  requires(std::is_arithmetic_v<T> || std::is_enum_v<T>) void field(T& x) { read(&x, sizeof x); }
  void field(std::string& s) {
    s.resize(count(1));
    read(s.data(), s.size());
  }
  void field(std::vector<double>& v) {
    v.resize(count(sizeof(double)));
    read(v.data(), v.size() * sizeof(double));
  }
  void doubles(double* x, std::size_t n) { read(x, n * sizeof(double)); }
  template <class T>
  std::size_t size(std::vector<T>& v) {
    v.resize(count(1));
    return v.size();
  }

 private:
  [[noreturn]] static void broken() {
    throw Error(ErrorCode::internal, "STEP importer", "its answer does not hold together");
  }
  std::size_t count(std::size_t item) {
    std::uint64_t n = 0;
    field(n);
    if (n > in_.size() / item) broken();
    return static_cast<std::size_t>(n);
  }
  void read(void* to, std::size_t size) {
    if (size > in_.size()) broken();
    if (size > 0) std::memcpy(to, in_.data(), size);
    in_.remove_prefix(size);
  }
  std::string_view in_;
};

template <class Codec, int D>
void walk(Codec& codec, std::vector<Eigen::Matrix<double, D, 1>>& points) {
  const std::size_t n = codec.size(points);
  if (n > 0) codec.doubles(points.front().data(), n * static_cast<std::size_t>(D));
}

template <class Codec>
void walk(Codec& codec, Frame& frame) {
  for (Vec3* v : {&frame.origin, &frame.x, &frame.y, &frame.z}) codec.doubles(v->data(), 3);
}

template <class Codec>
void walk(Codec& codec, PlainSurface& surface) {
  codec.field(surface.kind);
  walk(codec, surface.frame);
  codec.field(surface.radius);
  codec.field(surface.second);
  BSplineSurface& spline = surface.spline;
  codec.field(spline.degree_u);
  codec.field(spline.degree_v);
  codec.field(spline.knots_u);
  codec.field(spline.knots_v);
  walk(codec, spline.poles);
  codec.field(spline.weights);
  codec.field(spline.periodic_u);
  codec.field(spline.periodic_v);
}

template <class Codec>
void walk(Codec& codec, Coedge& coedge) {
  codec.field(coedge.pcurve.degree);
  codec.field(coedge.pcurve.knots);
  walk(codec, coedge.pcurve.poles);
  codec.field(coedge.pcurve.weights);
  codec.field(coedge.reversed);
  codec.field(coedge.edge);
}

template <class Codec>
void walk(Codec& codec, std::optional<std::array<double, 3>>& colour) {
  bool present = colour.has_value();
  codec.field(present);
  if (present && !colour) colour.emplace();
  if (present) codec.doubles(colour->data(), 3);
}

template <class Codec>
void walk(Codec& codec, PlainFace& face) {
  walk(codec, face.surface);
  codec.field(face.reversed);
  codec.size(face.loops);
  for (Loop& loop : face.loops) {
    codec.size(loop.coedges);
    for (Coedge& coedge : loop.coedges) walk(codec, coedge);
  }
  codec.field(face.name);
  codec.field(face.instance);
  codec.field(face.step_id);
  codec.field(face.body);
  walk(codec, face.colour);
}

template <class Codec>
void walk(Codec& codec, StepModel& head) {
  for (std::string* s : {&head.schema, &head.declared_unit, &head.sha256}) codec.field(*s);
  codec.field(head.unit_scale_to_mm);
  codec.field(head.solids);
  codec.field(head.shells);
  codec.field(head.sew_tolerance_mm);
  codec.field(head.sewn_edges);
  codec.field(head.greatest_sewn_gap_mm);
  codec.field(head.greatest_edge_gap_mm);
  codec.size(head.warnings);
  for (std::string& warning : head.warnings) codec.field(warning);
}

template <class Codec>
void walk(Codec& codec, PlainModel& model) {
  std::uint64_t word = magic;
  codec.field(word);
  if (word != magic) throw Error(ErrorCode::internal, "STEP importer", "its answer is of another version");
  walk(codec, model.head);
  codec.size(model.faces);
  for (PlainFace& face : model.faces) walk(codec, face);
  codec.size(model.edges);
  for (Edge& edge : model.edges) {
    codec.field(edge.degenerate);
    codec.field(edge.tolerance_mm);
  }
}

}  // namespace

std::string encode(const PlainModel& model) {
  Encoder encoder;
  // The walk takes references to mutable data for the sake of the decoder; the encoder only reads.
  walk(encoder, const_cast<PlainModel&>(model));
  return encoder.take();
}

PlainModel decode(std::string_view bytes) {
  PlainModel model;
  Decoder decoder(bytes);
  walk(decoder, model);
  if (!decoder.at_end()) throw Error(ErrorCode::internal, "STEP importer", "its answer is too long");
  return model;
}

Surface make_surface(PlainSurface plain) {
  switch (plain.kind) {
    case SurfaceKind::plane:
      return Surface::plane(plain.frame);
    case SurfaceKind::cylinder:
      return Surface::cylinder(plain.frame, plain.radius);
    case SurfaceKind::cone:
      return Surface::cone(plain.frame, plain.radius, plain.second);
    case SurfaceKind::sphere:
      return Surface::sphere(plain.frame, plain.radius);
    case SurfaceKind::torus:
      return Surface::torus(plain.frame, plain.radius, plain.second);
    case SurfaceKind::bspline:
      return Surface::bspline(std::move(plain.spline));
  }
  throw Error(ErrorCode::internal, "STEP importer", "unknown kind of surface");
}

StepModel to_step_model(PlainModel model, const std::string& where) {
  StepModel result = std::move(model.head);
  result.part.edges = std::move(model.edges);
  result.part.faces.reserve(model.faces.size());
  for (PlainFace& plain : model.faces) {
    const std::string entity = plain.step_id > 0 ? where + ":#" + std::to_string(plain.step_id) : where;
    try {
      result.part.faces.push_back({make_surface(std::move(plain.surface)), plain.reversed,
                                   std::move(plain.loops), std::move(plain.name), std::move(plain.instance),
                                   plain.step_id});
    } catch (const std::invalid_argument& fault) {
      throw Error(
          ErrorCode::bad_input, entity,
          std::string("has a surface that cannot be evaluated (") + fault.what() + "); export it again");
    }
    result.colours.push_back(plain.colour);
  }
  return result;
}

}  // namespace afptraj::step
