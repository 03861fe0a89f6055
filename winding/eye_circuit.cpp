#include "winding/eye_circuit.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/error.h"
#include "winding/frustum.h"
#include "winding/number_words.h"

namespace afptraj {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double most_bridging_mm = 0.01;
constexpr double sharpest_edge_rad = 0.1;  // over which what is laid still keeps to 0.01 mm

AxisValues axes_of(const EyePosition& eye) {
  return {eye.carriage_mm, degrees(eye.mandrel_rad), eye.cross_feed_mm, degrees(eye.rotation_rad)};
}

// How far a sample is from the straight piece between two others, by what is allowed.
double departure(const EyeSample& a, const EyeSample& b, const EyeSample& p) {
  const double way = b.length_mm - a.length_mm, share = way > 0 ? (p.length_mm - a.length_mm) / way : 0;
  const double round = radians(1) * value(p.axes, WinderAxis::cross_feed);  // mm by degree of the mandrel
  const AxisValues allowed{circuit_tolerance_mm, circuit_tolerance_mm / round, circuit_tolerance_mm,
                           circuit_rotation_deg};
  double worst = 0;
  for (std::size_t i = 0; i < winder_axes; ++i) {
    const double straight = a.axes[i] + share * (b.axes[i] - a.axes[i]);
    worst = std::max(worst, std::abs(p.axes[i] - straight) / allowed[i]);
  }
  return worst;
}

class CircuitMaker {
 public:
  CircuitMaker(const Meridian& meridian, const MeridianGeodesic& pass, const PayoutEye& eye)
      : meridian_(meridian), pass_(pass), eye_(eye) {}

  // `count` pieces by pass and more, closer at the turns.
  EyeCircuit dense(int count) {
    EyeCircuit out;
    out.least_free_mm = 1e300;
    kinks_.clear();
    const std::vector<FibrePoint> points = pass_.points_and_breaks(count);
    for (const FibrePoint& point : points) add(out, point, point.turn_rad, point.length_mm, point.angle_rad);
    for (std::size_t i = points.size() - 1; i-- > 0;) {
      const FibrePoint& point = points[i];
      add(out, point, 2 * pass_.turn_rad() - point.turn_rad, 2 * pass_.length_mm() - point.length_mm,
          pi - point.angle_rad);
    }
    return out;
  }

  // Whether the samples are so close that the pieces between them are straight to a fifth of what is allowed:
  // a piece of twice the length departs four times as much.
  bool close_enough(const std::vector<EyeSample>& samples) const {
    for (std::size_t i = 1; i + 1 < samples.size(); ++i) {
      if (!kinks_[i] && departure(samples[i - 1], samples[i + 1], samples[i]) > 0.8) return false;
    }
    return true;
  }

 private:
  void add(EyeCircuit& out, const FibrePoint& point, double turn, double length, double angle) {
    const FibreTangent path = fibre_tangent(meridian_, point.t, turn, angle);
    const EyePosition at = eye_.at(path);
    if (eye_.deepest_mm(path, at.free_length_mm) > most_bridging_mm) {
      throw Error(ErrorCode::no_path, "mandrel",
                  "is hollow along the fibre near z = " + significant_text(point.z_mm, 6) +
                      " mm, where the thread would bridge; give a steeper angle");
    }
    out.least_free_mm = std::min(out.least_free_mm, at.free_length_mm);
    out.most_free_mm = std::max(out.most_free_mm, at.free_length_mm);
    const std::vector<double>& breaks = meridian_.breaks();
    kinks_.push_back(std::binary_search(breaks.begin(), breaks.end(), point.t));
    out.samples.push_back({length, point.angle_rad, axes_of(at)});
  }

  const Meridian& meridian_;
  const MeridianGeodesic& pass_;
  const PayoutEye& eye_;
  std::vector<bool> kinks_;  // of the samples: where the meridian's curvature may jump, and the eye's speed
};

// Ramer, Douglas and Peucker's choice, along the path's length and with most of what is allowed.
void thin(const std::vector<EyeSample>& all, std::size_t first, std::size_t last,
          std::vector<EyeSample>& out) {
  std::size_t worst = first;
  double most = 0.8;
  for (std::size_t i = first + 1; i < last; ++i) {
    const double off = departure(all[first], all[last], all[i]);
    if (off > most) most = off, worst = i;
  }
  if (worst == first) {
    out.push_back(all[last]);
    return;
  }
  thin(all, first, worst, out);
  thin(all, worst, last, out);
}

// At an edge the eye would have to travel while nothing is laid.
void refuse_edges(const Meridian& meridian, const MeridianGeodesic& pass) {
  const double beside = 1e-9 * (meridian.last() - meridian.first());
  for (const double t : meridian.breaks()) {
    if (t <= pass.first().t + beside || t >= pass.last().t - beside) continue;
    const MeridianPoint a = meridian.at(t - beside), b = meridian.at(t + beside);
    const double bend = std::atan2(a.dz * b.dr - a.dr * b.dz, a.dz * b.dz + a.dr * b.dr);
    if (std::abs(bend) <= sharpest_edge_rad) continue;
    throw Error(ErrorCode::no_path, "mandrel",
                "has an edge of " + significant_text(degrees(std::abs(bend)), 3) +
                    " deg at z = " + significant_text(b.z_mm, 6) + " mm; round it");
  }
}

// Where a dome meets its cylinder in a hollow edge, as tabulated ones do by fractions of a degree, the eye on
// the tangent goes back at once. Where that is as little as is allowed for bridging it waits instead.
void keep_turning(std::vector<EyeSample>& samples) {
  double reached = -1e300;
  for (EyeSample& sample : samples) {
    double& mandrel = value(sample.axes, WinderAxis::mandrel);
    const double back = radians(reached - mandrel) * value(sample.axes, WinderAxis::cross_feed);
    if (back > 0 && back < most_bridging_mm) mandrel = reached;
    reached = std::max(reached, mandrel);
  }
}

}  // namespace

EyeCircuit eye_circuit(const Meridian& meridian, const MeridianGeodesic& pass, const PayoutEye& eye) {
  refuse_edges(meridian, pass);
  constexpr int fewest = 512, most = 32768;
  CircuitMaker maker(meridian, pass, eye);
  EyeCircuit circuit = maker.dense(fewest);
  for (int count = 2 * fewest; count <= most && !maker.close_enough(circuit.samples); count *= 2)
    circuit = maker.dense(count);
  std::vector<EyeSample> kept{circuit.samples.front()};
  thin(circuit.samples, 0, circuit.samples.size() - 1, kept);
  keep_turning(kept);
  circuit.samples = std::move(kept);
  return circuit;
}

}  // namespace afptraj
