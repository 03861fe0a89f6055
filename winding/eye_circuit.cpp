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
constexpr double shortest_piece_mm = 0.1;  // of fibre: over it the eye passes an edge of the meridian
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

// How far the straight pieces beside a sample are from the true axes, by what is allowed, were the longer of
// them on both sides. A piece between two samples departs by a quarter of that.
double unevenness(const EyeSample& a, const EyeSample& p, const EyeSample& b) {
  const double before = p.length_mm - a.length_mm, after = b.length_mm - p.length_mm;
  const double longer = std::max(before, after);
  if (!(before > 0 && after > 0) || longer < shortest_piece_mm) return 0;
  return departure(a, b, p) * longer * longer / (before * after);
}

class CircuitMaker {
 public:
  CircuitMaker(const Meridian& meridian, const FibrePass& pass, const PayoutEye& eye)
      : meridian_(meridian), pass_(pass), eye_(eye) {}

  // Samples so close that the pieces between them are straight to a fifth of what is allowed.
  EyeCircuit dense() {
    constexpr int first_count = 256, most_rounds = 12;
    const std::vector<Phase> phases = pass_.phases_and_breaks(first_count);
    const std::vector<FibrePoint> points = pass_.points_at(phases);
    for (std::size_t i = 0; i < points.size(); ++i) stations_.push_back(station(phases[i], points[i]));
    std::vector<EyeSample> samples = there_and_back();
    for (int round = 0; round < most_rounds && refine(samples); ++round) samples = there_and_back();
    return {std::move(samples), least_free_mm_, most_free_mm_};
  }

 private:
  using Phase = FibrePass::Phase;

  // A place of the pass, and the eye on both ways.
  struct Station {
    Phase phase;
    FibrePoint point;
    EyeSample there, back;
  };

  Station station(const Phase& phase, const FibrePoint& point) {
    return {phase, point, sample(point, point.turn_rad, point.length_mm, point.angle_rad),
            sample(point, 2 * pass_.turn_rad() - point.turn_rad, 2 * pass_.length_mm() - point.length_mm,
                   pi - point.angle_rad)};
  }

  EyeSample sample(const FibrePoint& point, double turn, double length, double angle) {
    const FibreTangent path = fibre_tangent(meridian_, point.t, turn, angle);
    const EyePosition at = eye_.at(path);
    if (eye_.deepest_mm(path, at.free_length_mm) > most_bridging_mm) {
      throw Error(ErrorCode::no_path, "mandrel",
                  "is hollow along the fibre near z = " + significant_text(point.z_mm, 6) +
                      " mm, where the thread would bridge; give a steeper angle");
    }
    least_free_mm_ = std::min(least_free_mm_, at.free_length_mm);
    most_free_mm_ = std::max(most_free_mm_, at.free_length_mm);
    return {length, point.angle_rad, axes_of(at)};
  }

  std::vector<EyeSample> there_and_back() const {
    std::vector<EyeSample> out;
    for (const Station& at : stations_) out.push_back(at.there);
    for (std::size_t i = stations_.size() - 1; i-- > 0;) out.push_back(stations_[i].back);
    return out;
  }

  // Where the path's curvature may jump, and the eye's speed with it.
  bool is_kink(const Phase& phase) const {
    const std::vector<double>& breaks = pass_.breaks();
    return std::binary_search(breaks.begin(), breaks.end(), phase.t);
  }

  // Halves pieces beside samples that are too uneven, there or back; false where none is.
  bool refine(const std::vector<EyeSample>& samples) {
    const std::size_t last = stations_.size() - 1;
    std::vector<bool> halved(last, false);
    bool any = false;
    const auto check = [&](std::size_t i, std::size_t station) {
      if (unevenness(samples[i - 1], samples[i], samples[i + 1]) <= 0.8) return;
      const double here = stations_[station].phase.phi;
      const double before = here - stations_[station - 1].phase.phi;
      const double after = stations_[station + 1].phase.phi - here;
      if (before >= 0.75 * after) halved[station - 1] = true;
      if (after >= 0.75 * before) halved[station] = true;
      any = true;
    };
    for (std::size_t station = 1; station < last; ++station) {
      if (is_kink(stations_[station].phase)) continue;
      check(station, station);
      check(2 * last - station, station);
    }
    // the turn at the last end, between there and back
    if (unevenness(samples[last - 1], samples[last], samples[last + 1]) > 0.8) halved[last - 1] = any = true;
    std::vector<Station> finer{stations_.front()};
    for (std::size_t i = 0; i < last; ++i) {
      if (halved[i]) {
        const Phase middle = pass_.between(stations_[i].phase, stations_[i + 1].phase);
        finer.push_back(station(middle, pass_.next_point(stations_[i].point, stations_[i].phase, middle)));
      }
      finer.push_back(stations_[i + 1]);
    }
    stations_ = std::move(finer);
    return any;
  }

  const Meridian& meridian_;
  const FibrePass& pass_;
  const PayoutEye& eye_;
  std::vector<Station> stations_;
  double least_free_mm_ = 1e300, most_free_mm_ = 0;
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
void refuse_edges(const Meridian& meridian, const FibrePass& pass) {
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

EyeCircuit eye_circuit(const Meridian& meridian, const FibrePass& pass, const PayoutEye& eye) {
  refuse_edges(meridian, pass);
  EyeCircuit circuit = CircuitMaker(meridian, pass, eye).dense();
  std::vector<EyeSample> kept{circuit.samples.front()};
  thin(circuit.samples, 0, circuit.samples.size() - 1, kept);
  keep_turning(kept);
  circuit.samples = std::move(kept);
  return circuit;
}

}  // namespace afptraj
