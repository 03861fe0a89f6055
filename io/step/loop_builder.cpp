#include "io/step/loop_builder.h"

#include <BRepTools_WireExplorer.hxx>
#include <BRep_Tool.hxx>
#include <Precision.hxx>
#include <ShapeFix_Edge.hxx>
#include <ShapeFix_Face.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Iterator.hxx>
#include <TopoDS_Wire.hxx>
#include <algorithm>
#include <cmath>
#include <optional>

#include "io/step/occt.h"

namespace afptraj::step {
namespace {

const Uv& start_of(const RawCoedge& c) { return c.reversed ? c.pcurve.poles.back() : c.pcurve.poles.front(); }
const Uv& end_of(const RawCoedge& c) { return c.reversed ? c.pcurve.poles.front() : c.pcurve.poles.back(); }
Uv& start_pole(RawCoedge& c) { return c.reversed ? c.pcurve.poles.back() : c.pcurve.poles.front(); }
Uv& end_pole(RawCoedge& c) { return c.reversed ? c.pcurve.poles.front() : c.pcurve.poles.back(); }

void shift(RawCoedge& c, const Uv& by) {
  for (Uv& pole : c.pcurve.poles) pole += by;
}

TopoDS_Face with_wires(const TopoDS_Face& face) {
  if (TopExp_Explorer(face, TopAbs_WIRE).More()) return face;
  ShapeFix_Face fix(face);
  fix.FixAddNaturalBoundMode() = 1;
  fix.Perform();
  return fix.Face();
}

/// The edges of a wire, one after the other; in the order of the file where they do not connect.
std::vector<TopoDS_Edge> ordered_edges(const TopoDS_Wire& wire, const TopoDS_Face& face) {
  std::vector<TopoDS_Edge> walked, listed;
  for (TopoDS_Iterator it(wire); it.More(); it.Next()) {
    const TopAbs_Orientation orientation = it.Value().Orientation();
    if (orientation == TopAbs_FORWARD || orientation == TopAbs_REVERSED)
      listed.push_back(TopoDS::Edge(it.Value()));
  }
  for (BRepTools_WireExplorer it(wire, face); it.More(); it.Next()) walked.push_back(it.Current());
  return walked.size() == listed.size() ? walked : listed;
}

RawCoedge make_coedge(const TopoDS_Edge& edge, const TopoDS_Face& face) {
  double first = 0, last = 0;
  Handle(Geom2d_Curve) curve = BRep_Tool::CurveOnSurface(edge, face, first, last);
  if (curve.IsNull()) {
    ShapeFix_Edge().FixAddPCurve(edge, face, BRep_Tool::IsClosed(edge, face), Precision::Confusion());
    curve = BRep_Tool::CurveOnSurface(edge, face, first, last);
  }
  if (curve.IsNull() || !(last > first)) {
    throw Error(ErrorCode::bad_input, "", "an edge has no curve in the parameters of its surface");
  }
  return {convert_pcurve(curve, first, last), edge.Orientation() == TopAbs_REVERSED,
          BRep_Tool::Degenerated(edge), BRep_Tool::Tolerance(edge), edge};
}

RawCoedge connector(const Uv& a, const Uv& b, bool degenerate, double tolerance_mm) {
  return {line_segment(a, b), false, degenerate, tolerance_mm, TopoDS_Edge()};
}

/// Closes the chains of one face.
class LoopCloser {
 public:
  LoopCloser(Handle(Geom_Surface) surface, std::vector<Repair>& repairs)
      : surface_(std::move(surface)), repairs_(repairs) {
    if (surface_->IsUPeriodic()) period_.x() = surface_->UPeriod();
    if (surface_->IsVPeriodic()) period_.y() = surface_->VPeriod();
  }

  void close(RawLoop& loop) {
    for (std::size_t i = 1; i < loop.size(); ++i)
      shift(loop[i], periods(end_of(loop[i - 1]) - start_of(loop[i])));
    RawLoop closed;
    for (std::size_t i = 0; i < loop.size(); ++i) {
      closed.push_back(loop[i]);
      const std::size_t next = (i + 1) % loop.size();
      RawCoedge& a = closed.back();
      RawCoedge& b = next == 0 ? closed.front() : loop[next];
      if (std::optional<RawCoedge> link = join(a, b)) closed.push_back(std::move(*link));
    }
    loop = std::move(closed);
  }

 private:
  Uv periods(const Uv& gap) const {
    Uv by = Uv::Zero();
    for (int k = 0; k < 2; ++k) {
      if (period_[k] > 0) by[k] = std::round(gap[k] / period_[k]) * period_[k];
    }
    return by;
  }

  Vec3 point(const Uv& uv) const { return to_vec3(surface_->Value(uv.x(), uv.y())); }

  /// Greatest distance of the straight segment in (u, v) from its start, in space.
  double reach_mm(const Uv& a, const Uv& b) const {
    const Vec3 from = point(a);
    double reach = 0;
    for (int k = 1; k <= 8; ++k) reach = std::max(reach, (point(a + (b - a) * k / 8) - from).norm());
    return reach;
  }

  /// Makes `a` end where `b` starts: moves the poles at the ends, or returns a coedge to insert.
  std::optional<RawCoedge> join(RawCoedge& a, RawCoedge& b) {
    const Uv from = end_of(a), to = start_of(b);
    const double gap = (to - from).norm();
    if (gap == 0) return std::nullopt;
    const double extent = std::max((a.pcurve.poles.front() - a.pcurve.poles.back()).norm(),
                                   (b.pcurve.poles.front() - b.pcurve.poles.back()).norm());
    const double gap_mm = reach_mm(from, to);
    const double slack_mm = 3 * std::max({a.tolerance_mm, b.tolerance_mm, Precision::Confusion()});
    const bool wide = gap > 1e-4 * extent;
    if (gap_mm <= slack_mm && wide) return connector(from, to, true, gap_mm);
    if (gap_mm > slack_mm) {
      repairs_.push_back({"a loop was open and is closed", gap_mm});
      if (wide) return connector(from, to, false, gap_mm);
    }
    meet(a, b);
    return std::nullopt;
  }

  /// Straight pcurves lie on seams and sides: they stay, curved ones give way.
  static void meet(RawCoedge& a, RawCoedge& b) {
    const bool straight_a = a.pcurve.degree == 1, straight_b = b.pcurve.degree == 1;
    const Uv at = straight_a == straight_b ? Uv(0.5 * (end_of(a) + start_of(b)))
                  : straight_a             ? end_of(a)
                                           : start_of(b);
    end_pole(a) = at;
    start_pole(b) = at;
  }

  Handle(Geom_Surface) surface_;
  std::vector<Repair>& repairs_;
  Uv period_ = Uv::Zero();
};

void reverse(RawLoop& loop) {
  std::reverse(loop.begin(), loop.end());
  for (RawCoedge& coedge : loop) coedge.reversed = !coedge.reversed;
}

/// Outer loop first and anticlockwise, the others clockwise.
void order_loops(RawLoops& raw) {
  std::vector<double> areas;
  for (const RawLoop& loop : raw.loops) areas.push_back(signed_area(loop));
  std::size_t outer = 0;
  for (std::size_t i = 1; i < areas.size(); ++i) {
    if (std::abs(areas[i]) > std::abs(areas[outer])) outer = i;
  }
  std::swap(raw.loops[0], raw.loops[outer]);
  std::swap(areas[0], areas[outer]);
  bool turned = false;
  for (std::size_t i = 0; i < areas.size(); ++i) {
    if (i == 0 ? areas[i] >= 0 : areas[i] <= 0) continue;
    reverse(raw.loops[i]);
    turned = true;
  }
  if (turned) raw.repairs.push_back({"a loop ran the wrong way round and is turned", 0});
}

}  // namespace

double signed_area(const RawLoop& loop) {
  double sum = 0;
  for (const RawCoedge& coedge : loop) {
    const std::vector<double> breaks = coedge.pcurve.breaks();
    const int pieces = coedge.pcurve.degree == 1 ? 1 : 8;
    Uv last = coedge.pcurve.point(breaks.front());
    double part = 0;
    for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
      for (int k = 1; k <= pieces; ++k) {
        const Uv next = coedge.pcurve.point(breaks[i] + (breaks[i + 1] - breaks[i]) * k / pieces);
        part += last.x() * next.y() - next.x() * last.y();
        last = next;
      }
    }
    sum += coedge.reversed ? -part : part;
  }
  return sum;
}

RawLoops build_loops(const TopoDS_Face& given) {
  const TopoDS_Face face = with_wires(TopoDS::Face(given.Oriented(TopAbs_FORWARD)));
  RawLoops raw;
  LoopCloser closer(untrimmed(BRep_Tool::Surface(face)), raw.repairs);
  for (TopoDS_Iterator it(face); it.More(); it.Next()) {
    if (it.Value().ShapeType() != TopAbs_WIRE) continue;
    RawLoop loop;
    for (const TopoDS_Edge& edge : ordered_edges(TopoDS::Wire(it.Value()), face))
      loop.push_back(make_coedge(edge, face));
    if (loop.empty()) continue;
    closer.close(loop);
    raw.loops.push_back(std::move(loop));
  }
  if (raw.loops.empty()) throw Error(ErrorCode::bad_input, "", "the face has no boundary");
  order_loops(raw);
  for (const RawLoop& loop : raw.loops) {
    for (const RawCoedge& coedge : loop) {
      for (const Uv& pole : coedge.pcurve.poles) raw.box.add(pole);
    }
  }
  return raw;
}

}  // namespace afptraj::step
