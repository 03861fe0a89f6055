#include "boundary/tow_lines.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <tbb/parallel_for.h>

#include "boundary/band_source.h"
#include "geometry/curvature.h"
#include "trajectory/front.h"
#include "trajectory/level_curve.h"

namespace afptraj {
namespace {

constexpr double least_stretch = 0.02;  // y: rays that have come together to this share are not laid on
constexpr double interpolated_stretch = 1e-5;  // curvatures within 1e-8 / mm, lengths within 1e-6 of themselves
constexpr double at_boundary_mm = 1e-3;
constexpr double longest_extension = 30;  // in bands: a boundary at 1 degree is passed within 28.6
constexpr double slack_mm = 1e-6;

/// The offsets of all lines, from the left, without repeats.
class Offsets {
 public:
  explicit Offsets(const TowLineOptions& options) : d_(options.tow_width_mm), tows_(options.tows) {
    for (int j = 0; j <= tows_; ++j) all_.push_back(edge(j));
    for (int j = 1; j <= tows_; ++j) all_.push_back(middle(j));
    const double p = options.coverage_rule;
    inner_ = p > 0 && p < 1 && p != 0.5;
    if (inner_)
      for (int j = 1; j <= tows_; ++j) {
        all_.push_back(edge(j - 1) - p * d_);
        all_.push_back(edge(j) + p * d_);
      }
    std::sort(all_.begin(), all_.end(), std::greater<>());
    all_.erase(std::unique(all_.begin(), all_.end(), [this](double a, double b) { return a - b < 1e-9 * d_; }),
               all_.end());
  }
  double edge(int j) const { return (0.5 * tows_ - j) * d_; }
  double middle(int j) const { return (0.5 * (tows_ + 1) - j) * d_; }
  bool has_inner() const { return inner_; }
  const std::vector<double>& all() const { return all_; }
  std::size_t index(double offset) const {
    const auto near = [&](double x) { return std::abs(x - offset) < 1e-8 * d_; };
    return static_cast<std::size_t>(std::find_if(all_.begin(), all_.end(), near) - all_.begin());
  }

 private:
  double d_;
  int tows_;
  bool inner_ = false;
  std::vector<double> all_;
};

/// A place of the head: the ends of the rays to all lines, in the order of Offsets.
struct Station {
  double t = 0, speed = 1;  ///< ds/dt of the centre line
  std::vector<GeodesicState> ends;
  std::vector<char> alive;
  bool outside = false;

  bool on_skin() const {
    for (std::size_t i = 0; i < ends.size(); ++i)
      if (alive[i] && !ends[i].outside) return true;
    return false;
  }
};

/// A state at x of the way from a to b, `h` apart: cubic in (u, v) and in y.
GeodesicState between(const GeodesicState& a, const GeodesicState& b, double h, double x) {
  const UvCubic way = UvCubic::hermite(a.at.uv, h * a.duv, b.at.uv, h * b.duv);
  const UvCubic field = UvCubic::hermite({a.y, 0}, {h * a.dy, 0}, {b.y, 0}, {h * b.dy, 0});
  GeodesicState out = a;
  out.at.uv = way.point(x);
  out.duv = way.derivative(x) / h;
  out.y = field.point(x).x();
  out.dy = field.derivative(x).x() / h;
  out.s_mm = a.s_mm + x * h;
  return out;
}

/// A node of a line, with the derivatives of the surface there.
struct LineNode {
  CurveNode node;
  SurfaceDerivatives d;
};

/// Tangent and speed by Gauss's lemma and the Jacobi field, as level_node() does.
LineNode line_node(const Skin& skin, const Station& station, std::size_t line, int side) {
  const GeodesicState& end = station.ends[line];
  LineNode out;
  out.d = skin.derivatives(end.at);
  out.node.t = station.t;
  out.node.at = end.at;
  out.node.normal_sign = end.normal_sign;
  const double sign = skin.face(end.at.face).reversed ? -end.normal_sign : end.normal_sign;
  const Vec3 normal = sign * unit_normal(out.d);
  const Vec3 along = side * uv_to_tangent(out.d, end.duv).cross(normal);
  out.node.duv = end.y * station.speed * tangent_to_uv(out.d, along);
  out.node.kg_per_mm = -side * end.dy / end.y;
  return out;
}

/// Whether the cubic between two nodes is smooth: same_chart() of front.h over derivatives at hand.
bool joins(const Skin& skin, const LineNode& a, const LineNode& b) {
  if (a.node.at.face != b.node.at.face || a.node.normal_sign != b.node.normal_sign) return false;
  if (crease_between(skin.face(a.node.at.face).surface, a.node.at.uv, b.node.at.uv)) return false;
  const Uv miss = b.node.at.uv - a.node.at.uv - 0.5 * (b.node.t - a.node.t) * (a.node.duv + b.node.duv);
  const double off = std::max(uv_to_tangent(a.d, miss).norm(), uv_to_tangent(b.d, miss).norm());
  return off <= 0.05 * (a.d.S - b.d.S).norm() + 1e-9;
}

class BandBuilder {
 public:
  BandBuilder(const GeodesicTracer& tracer, const TowLineOptions& options, const Offsets& offsets)
      : tracer_(tracer), skin_(tracer.skin()), options_(options), offsets_(offsets) {
    half_mm_ = offsets.edge(0);
    const auto& all = offsets.all();
    zero_ = static_cast<std::size_t>(
        std::find_if(all.begin(), all.end(), [](double x) { return x < slack_mm; }) - all.begin());
  }

  /// Extends the source past its ends that lie off the skin.
  void extend(BandSource& source) const {
    if (source.closed()) return;
    for (const bool backward : {true, false}) {
      const SourceCurve::Frame end = source.at(backward ? source.first() : source.last());
      if (!end.outside && !at_free_edge(end.at)) continue;
      std::vector<GeodesicState> states = extension(end, backward);
      if (states.size() > 1) source.extend(tracer_, std::move(states), backward);
    }
  }

  std::vector<Station> stations(const BandSource& source, double curve_first, double curve_last) const {
    const double length = source.last() - source.first();
    const int n = std::max(2, static_cast<int>(std::ceil(length / options_.station_mm)));
    std::vector<Station> out;
    for (int i = 0; i <= n; ++i) {
      const double t = source.first() + length * i / n;
      out.push_back(station(source, t, t >= curve_first && t <= curve_last));
    }
    for (int round = 0; round < 8 && refine(source, out, curve_first, curve_last); ++round) {
    }
    return out;
  }

 private:
  bool at_free_edge(const SurfacePoint& at) const {
    const SurfaceDerivatives d = skin_.derivatives(at);
    const LoopCrossing edge = skin_.trim(at.face).nearest(at.uv, first_form(d).matrix());
    return (skin_.point({at.face, edge.uv}) - d.S).norm() < at_boundary_mm &&
           !skin_.mate({at.face, edge.loop, edge.coedge});
  }

  Station station(const SourceCurve::Frame& frame, double t) const {
    const auto& all = offsets_.all();
    Station out;
    out.t = t;
    out.speed = frame.speed;
    out.outside = frame.outside;
    out.ends.resize(all.size());
    out.alive.assign(all.size(), 0);
    for (const int side : {1, -1}) {
      walk(out, tracer_.start(frame.at, side * frame.frame.left(), frame.normal_sign, 1, -side * frame.kg_per_mm,
                              frame.outside),
           side);
    }
    return out;
  }

  /// A station of the curve itself, far from the skin, has no tows: no rays are shot.
  Station station(const BandSource& source, double t, bool of_curve) const {
    const SourceCurve::Frame frame = source.at(t);
    if (of_curve && frame.outside) {
      const double reach = half_mm_ + options_.station_mm + options_.beyond_mm;
      if (!skin_.closest_point().closest(frame.frame.position, reach)) {
        Station none;
        none.t = t;
        none.outside = true;
        none.ends.resize(offsets_.all().size());
        none.alive.assign(offsets_.all().size(), 0);
        return none;
      }
    }
    return station(frame, t);
  }

  /// Walks a ray outward, over as many lines at once as can be interpolated.
  void walk(Station& out, GeodesicState g, int side) const {
    const auto& all = offsets_.all();
    const auto next = [&](std::size_t i, std::size_t by) { return side > 0 ? i - by : i + by; };  // left: wraps at the end
    if (side > 0) {
      out.ends[zero_] = g;
      out.alive[zero_] = 1;
    }
    std::size_t i = next(zero_, 1);
    std::size_t stride = all.size();
    while (i < all.size()) {
      stride = std::min(stride, side > 0 ? i + 1 : all.size() - i);
      const std::size_t stop = next(i, stride - 1);
      const double h = std::abs(all[stop]) - g.s_mm;
      GeodesicState end = g;
      const bool reached = tracer_.advance(end, h) == TraceEnd::reached && end.y > least_stretch;
      if (stride > 1 && !(reached && interpolates(g, end, h))) {
        stride /= 2;
        continue;
      }
      if (!reached) return;
      for (; i != stop; i = next(i, 1)) {
        out.ends[i] = between(g, end, h, (std::abs(all[i]) - g.s_mm) / h);
        out.alive[i] = 1;
      }
      out.ends[stop] = g = end;
      out.alive[stop] = 1;
      i = next(stop, 1);
    }
  }

  /// The cubic's error is h^4 u'''' / 384; what the trapezoidal rule misses is m = h^3 u''' / 12. Where the surface
  /// changes over lengths above h, the error is below m / 32.
  bool interpolates(const GeodesicState& a, const GeodesicState& b, double h) const {
    if (a.at.face != b.at.face || a.normal_sign != b.normal_sign || a.outside != b.outside) return false;
    const Surface& surface = skin_.face(a.at.face).surface;
    if (crease_between(surface, a.at.uv, b.at.uv)) return false;
    const Uv miss = b.at.uv - a.at.uv - 0.5 * h * (a.duv + b.duv);
    const double miss_y = b.y - a.y - 0.5 * h * (a.dy + b.dy);
    return uv_to_tangent(skin_.derivatives(a.at), miss).norm() < 16 * options_.tolerance_mm &&
           std::abs(miss_y) < interpolated_stretch;
  }

  std::vector<GeodesicState> extension(const SourceCurve::Frame& end, bool backward) const {
    const Vec3 along = backward ? Vec3(-end.frame.tangent) : end.frame.tangent;
    GeodesicState g = tracer_.start(end.at, along, end.normal_sign, 1, 0, true);
    std::vector<GeodesicState> states = {g};
    // How far no line has been on the skin; below zero: they are.
    double clear = on_skin(g, backward) ? -1 : 0;
    while (g.s_mm < 2 * half_mm_ * longest_extension && clear < options_.beyond_mm) {
      if (tracer_.advance(g, options_.station_mm) != TraceEnd::reached) break;
      const bool on = on_skin(g, backward);
      if (on && clear >= options_.station_mm) break;  // another place of the skin
      states.push_back(g);
      clear = on ? -1 : std::max(clear, 0.0) + options_.station_mm;
    }
    return states;
  }
  bool on_skin(const GeodesicState& g, bool backward) const {
    SourceCurve::Frame frame;
    frame.at = g.at;
    frame.frame = frame_of(skin_, g);
    if (backward) frame.frame.tangent = -frame.frame.tangent;
    frame.normal_sign = g.normal_sign;
    frame.outside = g.outside;
    return !g.outside || station(frame, 0).on_skin();
  }

  /// Halves the gaps in which a cubic would miss; false when there are none.
  bool refine(const BandSource& source, std::vector<Station>& stations, double curve_first, double curve_last) const {
    std::vector<char> halve(stations.size(), 0);  // the gap after station i
    const std::size_t lines[] = {0, offsets_.all().size() - 1};
    for (std::size_t i = 1; i + 1 < stations.size(); ++i)
      for (const std::size_t line : lines)
        if (misses(stations[i - 1], stations[i], stations[i + 1], line)) halve[i - 1] = halve[i] = 1;
    std::vector<Station> out;
    bool added = false;
    for (std::size_t i = 0; i < stations.size(); ++i) {
      const double t = stations[i].t;
      out.push_back(std::move(stations[i]));
      if (!halve[i] || stations[i + 1].t - t < 0.02 * options_.station_mm) continue;
      const double mid = 0.5 * (t + stations[i + 1].t);
      out.push_back(station(source, mid, mid >= curve_first && mid <= curve_last));
      added = true;
    }
    stations = std::move(out);
    return added;
  }

  /// Whether the cubic over every second station is off by so much that those over every one are.
  bool misses(const Station& a, const Station& b, const Station& c, std::size_t line) const {
    if (!a.alive[line] || !b.alive[line] || !c.alive[line]) return false;
    const int side = line == 0 ? 1 : -1;
    const LineNode la = line_node(skin_, a, line, side), lb = line_node(skin_, b, line, side),
                   lc = line_node(skin_, c, line, side);
    if (!joins(skin_, la, lb) || !joins(skin_, lb, lc)) return false;
    const CurveNode &na = la.node, &nb = lb.node, &nc = lc.node;
    const double h1 = nb.t - na.t, h2 = nc.t - nb.t;
    const Uv off = cubic({na, nc}, 0).point(h1 / (h1 + h2)) - nb.at.uv;
    const double ratio = std::min(4.0, std::max(h1, h2) / std::min(h1, h2));
    return uv_to_tangent(lb.d, off).norm() * ratio * ratio / 16 > options_.tolerance_mm;
  }

  const GeodesicTracer& tracer_;
  const Skin& skin_;
  const TowLineOptions& options_;
  const Offsets& offsets_;
  double half_mm_ = 0;
  std::size_t zero_ = 0;  ///< the first line that is not left of the centre
};

GeodesicOptions tow_geodesics(const Skin& skin, const TowLineOptions& options) {
  GeodesicOptions out;
  out.tolerance_mm = 1e-3 * options.tolerance_mm;
  out.outside_limit_mm = skin.diagonal();
  out.margin_mm = options.tow_width_mm * options.tows * longest_extension + options.beyond_mm;
  return out;
}

/// The line at one offset of a band, as far as rays lead.
TowLine line_at(const GeodesicTracer& tracer, double offset_mm, std::size_t index,
                const std::shared_ptr<const BandSource>& source, const std::vector<Station>& all) {
  const int side = offset_mm >= 0 ? 1 : -1;
  TowLine out;
  out.offset_mm = offset_mm;
  std::optional<Front> front;  // for the runs that do not stay on one face
  int number = 0;
  // Most runs stay on one face: their nodes are the curve. The others need their passages found.
  const auto finish = [&](std::size_t first, std::size_t last) {
    if (last < first + 2) return;
    const bool closed = source->closed() && last - first == all.size();
    std::vector<CurveNode> nodes;
    nodes.reserve(last - first);
    LineNode before;
    bool smooth = true;
    for (std::size_t i = first; i < last && smooth; ++i) {
      const LineNode node = line_node(tracer.skin(), all[i], index, side);
      smooth = i == first || joins(tracer.skin(), before, node);
      nodes.push_back(node.node);
      before = node;
    }
    if (smooth) {
      out.runs.push_back({{std::move(nodes)}, closed});
      return;
    }
    if (!front) {
      FrontOptions options;
      options.spacing_mm = std::abs(offset_mm);
      front.emplace(tracer, side, options);
      number = front->add_source(source, 0);
    }
    Strand strand;
    strand.source = number;
    for (std::size_t i = first; i < last; ++i) strand.rays.push_back({all[i].t, all[i].ends[index]});
    if (closed) {
      strand.end[0] = strand.end[1] = StrandEnd::linked;
      strand.link[0] = strand.link[1] = 0;
    }
    front->add_strand(std::move(strand));
  };
  std::size_t first = 0;
  for (std::size_t i = 0; i <= all.size(); ++i)
    if (i == all.size() || !all[i].alive[index]) {
      finish(first, i);
      first = i + 1;
    }
  if (front)
    for (ChainedCurve& chain : level_curves(tracer, *front, 1)) out.runs.push_back(std::move(chain.curve));
  std::sort(out.runs.begin(), out.runs.end(),
            [](const SurfaceCurve& a, const SurfaceCurve& b) { return a.first() < b.first(); });
  return out;
}

}  // namespace

struct TowBandMaker::Parts {
  Parts(const Skin& on, const TowLineOptions& asked)
      : skin(on), options(asked), tracer(on, tow_geodesics(on, asked)), offsets(asked), builder(tracer, options, offsets) {}
  const Skin& skin;
  TowLineOptions options;
  GeodesicTracer tracer;
  Offsets offsets;
  BandBuilder builder;
};

TowBandMaker::TowBandMaker(const Skin& skin, const TowLineOptions& options)
    : parts_(std::make_unique<const Parts>(skin, options)) {}
TowBandMaker::~TowBandMaker() = default;

std::optional<TowBand> TowBandMaker::band(int course, const SurfaceCurve& curve) const {
  const TowLineOptions& options = parts_->options;
  const Offsets& offsets = parts_->offsets;
  const auto source = std::make_shared<BandSource>(parts_->skin, curve);
  parts_->builder.extend(*source);
  const std::vector<Station> stations = parts_->builder.stations(*source, curve.first(), curve.last());
  if (std::none_of(stations.begin(), stations.end(), [](const Station& s) { return s.on_skin(); })) return std::nullopt;
  TowBand out;
  out.course = course;
  out.closed = source->closed();
  out.first = source->first();
  out.last = source->last();
  const auto line = [&](double offset) {
    const std::size_t index = offsets.index(offset);
    return line_at(parts_->tracer, offsets.all()[index], index, source, stations);
  };
  const double p = options.coverage_rule, d = options.tow_width_mm;
  for (int j = 0; j <= options.tows; ++j) out.edges.push_back(line(offsets.edge(j)));
  for (int j = 1; j <= options.tows; ++j) {
    out.middles.push_back(line(offsets.middle(j)));
    if (!offsets.has_inner()) continue;
    out.from_left.push_back(line(offsets.edge(j - 1) - p * d));
    out.from_right.push_back(line(offsets.edge(j) + p * d));
  }
  return out;
}

std::vector<TowBand> tow_bands(const Skin& skin, const std::vector<LevelCurve>& levels, const TowLineOptions& options) {
  const TowBandMaker maker(skin, options);
  std::vector<std::pair<int, const SurfaceCurve*>> curves;
  for (const LevelCurve& level : levels)
    for (const SurfaceCurve& curve : level.curves) curves.emplace_back(level.number, &curve);
  std::vector<std::optional<TowBand>> made(curves.size());
  tbb::parallel_for(std::size_t{0}, curves.size(),
                    [&](std::size_t i) { made[i] = maker.band(curves[i].first, *curves[i].second); });
  std::vector<TowBand> out;
  for (auto& band : made)
    if (band) out.push_back(std::move(*band));
  return out;
}

}  // namespace afptraj
