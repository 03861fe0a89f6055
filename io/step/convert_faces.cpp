#include "io/step/convert_faces.h"

#include <BRep_Tool.hxx>
#include <GeomAdaptor_Curve.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <utility>

#include "io/step/loop_builder.h"
#include "io/step/match_edges.h"
#include "io/step/occt.h"

namespace afptraj::step {
namespace {

/// Numbers of edges; two uses of one edge in the same body share theirs.
class EdgeBook {
 public:
  explicit EdgeBook(std::vector<Edge>& edges) : edges_(edges) {}

  int number(const RawCoedge& coedge, int body) {
    if (coedge.edge.IsNull() || coedge.degenerate) return add(coedge);
    Body& known = bodies_[body];
    const int index = known.edges.Add(coedge.edge);
    if (index > static_cast<int>(known.numbers.size())) {
      known.numbers.push_back(add(coedge));
      known.uses.push_back(1);
      return known.numbers.back();
    }
    if (++known.uses[static_cast<std::size_t>(index - 1)] > 2) {
      ++crowded_;
      return add(coedge);
    }
    return known.numbers[static_cast<std::size_t>(index - 1)];
  }
  int crowded() const { return crowded_; }

 private:
  struct Body {
    TopTools_IndexedMapOfShape edges;
    std::vector<int> numbers, uses;
  };
  int add(const RawCoedge& coedge) {
    edges_.push_back({coedge.degenerate, coedge.tolerance_mm});
    return static_cast<int>(edges_.size()) - 1;
  }
  std::vector<Edge>& edges_;
  std::map<int, Body> bodies_;
  int crowded_ = 0;
};

std::vector<double> smooth_intervals(const Handle(Geom_Curve)& curve, double first, double last) {
  const GeomAdaptor_Curve adaptor(curve, first, last);
  TColStd_Array1OfReal ends(1, adaptor.NbIntervals(GeomAbs_CN) + 1);
  adaptor.Intervals(ends, GeomAbs_CN);
  return {ends.begin(), ends.end()};
}

/// Curved pcurves that miss the edge's curve in space while the surface does pass through it are
/// poor images (projections by some program, often OpenCASCADE itself): they are made anew.
class PcurveRefiner {
 public:
  explicit PcurveRefiner(const PlainSurface& plain) : plain_(plain) {}

  void refine(RawCoedge& coedge) {
    if (coedge.edge.IsNull() || coedge.degenerate || coedge.pcurve.degree == 1) return;
    double first = 0, last = 0;
    const Handle(Geom_Curve) curve = BRep_Tool::Curve(coedge.edge, first, last);
    BSplineCurve2& pcurve = coedge.pcurve;
    if (curve.IsNull() ||
        std::abs(first - pcurve.first()) + std::abs(last - pcurve.last()) > 1e-9 * (last - first))
      return;
    if (!surface_) surface_ = make_surface(plain_);
    const auto point = [&](double t) { return to_vec3(curve->Value(t)); };
    const auto [distance, at] = deviation(pcurve, point);
    if (distance <= visible_mm || foot_distance(*surface_, point(at), pcurve.point(at)) > 0.3 * distance)
      return;
    BSplineCurve2 better = pcurve_of_feet(point, smooth_intervals(curve, first, last), {&*surface_, &pcurve});
    if (deviation(better, point).first <= 0.5 * distance) pcurve = std::move(better);
  }

 private:
  static constexpr double visible_mm = 1e-6;

  /// Greatest distance from the curve in space, and where.
  template <class Point>
  std::pair<double, double> deviation(const BSplineCurve2& pcurve, const Point& point) const {
    std::pair<double, double> worst{0, pcurve.first()};
    const std::vector<double> breaks = pcurve.breaks();
    const int pieces = std::max(4, 64 / static_cast<int>(breaks.size()));
    for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
      for (int k = 0; k < pieces; ++k) {
        const double t = breaks[i] + (breaks[i + 1] - breaks[i]) * (k + 0.5) / pieces;
        if (const double d = (surface_->point(pcurve.point(t)) - point(t)).norm(); d > worst.first)
          worst = {d, t};
      }
    }
    return worst;
  }

  const PlainSurface& plain_;
  std::optional<Surface> surface_;
};

bool is_sound(const PlainSurface& surface) {
  const auto finite = [](double x) { return std::isfinite(x); };
  bool sound = finite(surface.radius) && finite(surface.second);
  for (const Vec3* v : {&surface.frame.origin, &surface.frame.x, &surface.frame.y, &surface.frame.z})
    sound = sound && v->allFinite();
  const BSplineSurface& spline = surface.spline;
  return sound &&
         std::all_of(spline.poles.begin(), spline.poles.end(), [](const Vec3& p) { return p.allFinite(); }) &&
         std::all_of(spline.weights.begin(), spline.weights.end(),
                     [&](double w) { return finite(w) && w > 0; });
}

PlainFace convert_face(const SourceFace& source, EdgeBook& book, std::vector<Repair>& repairs) {
  const gp_Trsf placement = source.face.Location().Transformation();
  if (std::abs(std::abs(placement.ScaleFactor()) - 1) > 1e-9)
    throw Error(ErrorCode::bad_input, "", "its instance is scaled");
  RawLoops raw = build_loops(source.face);
  const ConvertedSurface converted = convert_surface(BRep_Tool::Surface(source.face), raw.box);
  if (converted.error_mm > converted.tolerance_mm) {
    repairs.push_back({"its surface is not followed to 1e-9 mm", converted.error_mm});
  }
  if (!is_sound(converted.surface))
    throw Error(ErrorCode::bad_input, "", "its surface has a coordinate or weight that is not a number");
  PlainFace face;
  face.surface = converted.surface;
  // A mirrored placement turns S_u x S_v but not the mark of the face.
  face.reversed = (source.face.Orientation() == TopAbs_REVERSED) != static_cast<bool>(placement.IsNegative());
  face.name = source.name;
  face.instance = source.instance;
  face.step_id = source.step_id;
  face.colour = source.colour;
  face.body = source.in_solid ? source.group : -1;
  PcurveRefiner refiner(face.surface);
  for (RawLoop& raw_loop : raw.loops) {
    Loop loop;
    for (RawCoedge& coedge : raw_loop) {
      refiner.refine(coedge);
      const int edge = book.number(coedge, face.body);
      loop.coedges.push_back({std::move(coedge.pcurve), coedge.reversed, edge});
    }
    face.loops.push_back(std::move(loop));
  }
  repairs.insert(repairs.end(), raw.repairs.begin(), raw.repairs.end());
  return face;
}

/// What happened to faces: one line a kind of repair, with the first face and the greatest size.
class RepairLog {
 public:
  void add(const Repair& repair, const SourceFace& face) {
    Entry& entry = entries_[repair.what];
    if (entry.count++ == 0) entry.first = face.step_id > 0 ? "#" + std::to_string(face.step_id) : face.name;
    entry.mm = std::max(entry.mm, repair.mm);
  }
  void report(std::vector<std::string>& warnings) const {
    for (const auto& [what, entry] : entries_) {
      char size[48] = "";
      if (entry.mm > 0) std::snprintf(size, sizeof size, ", by up to %.2g mm", entry.mm);
      const std::string more = entry.count > 1 ? " (" + std::to_string(entry.count) + " times in all)" : "";
      warnings.push_back("face " + entry.first + ": " + what + size + more);
    }
  }

 private:
  struct Entry {
    int count = 0;
    double mm = 0;
    std::string first;
  };
  std::map<std::string, Entry> entries_;
};

}  // namespace

void convert_faces(const std::vector<SourceFace>& faces, PlainModel& model) {
  EdgeBook book(model.edges);
  RepairLog log;
  for (const SourceFace& source : faces) {
    std::vector<Repair> repairs;
    try {
      model.faces.push_back(occt_guard(ErrorCode::bad_input, "", "converting a face",
                                       [&] { return convert_face(source, book, repairs); }));
    } catch (const Error& error) {
      repairs.assign(1, {std::string("left out: ") + error.what(), 0});
    }
    for (const Repair& repair : repairs) log.add(repair, source);
  }
  log.report(model.head.warnings);
  if (book.crowded() > 0) {
    model.head.warnings.push_back(std::to_string(book.crowded()) +
                                  " uses of edges where more than two faces meet were made free edges");
  }
}

}  // namespace afptraj::step
