#include "winding/vessel_program.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/error.h"
#include "winding/eye_circuit.h"
#include "winding/frustum.h"
#include "winding/grown_mandrel.h"
#include "winding/number_words.h"

namespace afptraj {
namespace {

std::string layer_place(std::size_t number) { return "layer " + std::to_string(number); }

VesselQuery query_of(const VesselLayer& layer, const WindTow& tow) {
  VesselQuery query;
  query.angle_deg = layer.angle_deg;
  query.tolerance_deg = layer.tolerance_deg;
  query.tow_width_mm = tow.width_mm;
  query.most_overlap = layer.most_overlap;
  query.steering = layer.steering;
  query.steering.tow_width_mm = tow.width_mm;
  if (layer.circuits || layer.stride) query.most_starts = 1'000'000;  // whatever is chosen
  return query;
}

bool turns_back(const EyeSample& from, const EyeSample& to) {
  return value(to.axes, WinderAxis::mandrel) < value(from.axes, WinderAxis::mandrel);
}

// Writes the layers of one program.
class VesselPlanner {
 public:
  VesselPlanner(const VesselWinding& winding, const MachineProfile& profile, OverSpeed over_speed,
                const MachineWriter::Sink& sink)
      : winding_(winding),
        profile_(profile),
        over_speed_(over_speed),
        writer_(profile, sink),
        mandrel_(std::make_shared<const Meridian>(winding.meridian)) {
    eye_.emplace(*mandrel_, profile_.eye_room);
  }

  VesselReport write() {
    VesselReport report;
    writer_.header(winding_.meridian, winding_.tow);
    for (std::size_t i = 0; i < winding_.layers.size(); ++i) report.layers.push_back(write_layer(i));
    writer_.end();
    report.lines = writer_.lines();
    return report;
  }

 private:
  VesselLayerReport write_layer(std::size_t index) {
    const std::int64_t lines_before = writer_.lines();
    VesselLayerReport report;
    const VesselLayer& layer = winding_.layers[index];
    const Meridian& meridian = *mandrel_;
    report.mandrel = mandrel_;
    report.pattern = layer.hoop ? hoop_pattern(meridian, winding_.tow, index + 1)
                                : layer_pattern(meridian, winding_.tow, layer, index + 1);
    const SteeringRule rule = layer.hoop ? hoop_rule(report.pattern.angle_deg, winding_.tow)
                                         : query_of(layer, winding_.tow).steering;
    const std::optional<SteeredPass> steered = PassMaker(meridian, rule).at(report.pattern.angle_deg);
    const FibrePass& pass = steered.value().pass;
    const EyeCircuit circuit = eye_circuit(meridian, pass, *eye_);
    report.least_free_mm = circuit.least_free_mm;
    report.most_free_mm = circuit.most_free_mm;
    write_comment(report.pattern, index);
    if (index > 0 && winding_.growth) writer_.mandrel(meridian);
    const double turned = approach(circuit.samples.front().axes, index, report);
    writer_.comment("Tow fixed at z " + header_number(pass.first().z_mm) + " r " +
                    header_number(pass.first().r_mm) + " turn 0");
    lay(circuit, turned, index, report);
    writer_.comment("Tow cut");
    retreat(index, report);
    grow(pass, index, report);
    report.lines = writer_.lines() - lines_before;
    return report;
  }

  // The mandrel of the next layer.
  void grow(const FibrePass& pass, std::size_t index, VesselLayerReport& report) {
    const Meridian& meridian = *mandrel_;
    const VesselLayer& layer = winding_.layers[index];
    const PassMaker passes(meridian, {});
    const LayerGrowth growth =
        layer.hoop ? hoop_growth(meridian, passes.widest_first_t(), passes.widest_last_t(), winding_.tow)
                   : helical_growth(meridian, pass, report.pattern.circuits, winding_.tow);
    report.least_thickness_mm = 1e300;
    constexpr int samples = 64;
    for (int i = 0; i <= samples; ++i) {
      const double t = pass.first().t + (pass.last().t - pass.first().t) * i / samples;
      const double thickness = growth.thickness_mm(t);
      report.least_thickness_mm = std::min(report.least_thickness_mm, thickness);
      report.most_thickness_mm = std::max(report.most_thickness_mm, thickness);
    }
    if (!winding_.growth || index + 1 == winding_.layers.size()) return;
    mandrel_ = std::make_shared<const Meridian>(grown_mandrel(meridian, growth));
    eye_.emplace(*mandrel_, profile_.eye_room);
  }

  void write_comment(const VesselPattern& pattern, std::size_t index) {
    writer_.comment(
        "Layer " + std::to_string(index + 1) + " of " + std::to_string(winding_.layers.size()) +
        (winding_.layers[index].hoop ? ": hoop" : ": helical") + ", angle " +
        header_number(pattern.angle_deg) + ", circuits " + std::to_string(pattern.circuits) + ", stride " +
        std::to_string(pattern.stride) + ", starts " + std::to_string(pattern.starts) +
        (pattern.leading ? " leading" : " lagging") +
        (pattern.ratio_first != 0 || pattern.ratio_last != 0
             ? ", steering " + header_number(pattern.ratio_first) + " " + header_number(pattern.ratio_last)
             : ""));
  }

  // Where the eye is free of the mandrel, all along it.
  double safe_mm() const {
    return profile_.eye_room.fixed_mm.value_or(eye_->envelope().widest_mm() +
                                               eye_->envelope().clearance_mm());
  }

  // Out, along, and in; returns the whole turns that the mandrel has made, in degrees.
  double approach(const AxisValues& start, std::size_t index, VesselLayerReport& report) {
    const double turned =
        360 * std::ceil((value(at_, WinderAxis::mandrel) - value(start, WinderAxis::mandrel)) / 360);
    AxisValues out = at_, along = start, in = start;
    value(out, WinderAxis::cross_feed) = value(along, WinderAxis::cross_feed) = safe_mm();
    value(along, WinderAxis::mandrel) += turned;
    value(in, WinderAxis::mandrel) += turned;
    reposition({out, along, in}, index, report);
    return turned;
  }

  void retreat(std::size_t index, VesselLayerReport& report) {
    AxisValues out = at_;
    value(out, WinderAxis::cross_feed) = safe_mm();
    reposition({out}, index, report);
  }

  void reposition(const std::vector<AxisValues>& places, std::size_t index, VesselLayerReport& report) {
    std::vector<MachineMove> moves;
    double carriage = value(at_, WinderAxis::carriage);
    for (const AxisValues& place : places) {
      moves.push_back({place, MovePurpose::reposition});
      report.repositioned_mm += std::abs(value(place, WinderAxis::carriage) - carriage);
      carriage = value(place, WinderAxis::carriage);
    }
    run(moves, index, report);
    for (std::size_t i = 0; i < moves.size(); ++i) {
      // the first move along says where all axes stand, which nobody knows of a machine that starts
      if (!placed_ && i == 1) {
        writer_.place(moves[i]);
        placed_ = true;
      } else {
        writer_.move(moves[i]);
      }
    }
    writer_.roll_over();
  }

  void lay(const EyeCircuit& circuit, double turned, std::size_t index, VesselLayerReport& report) {
    const std::vector<EyeSample>& samples = circuit.samples;
    const std::int64_t N = report.pattern.circuits;
    std::vector<MachineMove> moves;
    for (std::int64_t k = 0; k < N; ++k) {
      const double turn = turned + static_cast<double>(k) * report.pattern.turn_deg;
      for (std::size_t i = 1; i < samples.size(); ++i) {
        MachineMove move{samples[i].axes, MovePurpose::lay, samples[i].length_mm - samples[i - 1].length_mm,
                         samples[i].angle_rad};
        value(move.to, WinderAxis::mandrel) += turn;
        report.laid_mm += move.way_mm;
        report.backward_turns += turns_back(samples[i - 1], samples[i]) ? 1 : 0;
        moves.push_back(move);
      }
    }
    run(moves, index, report);
    for (std::size_t i = 0; i < moves.size(); ++i) {
      const std::size_t by_circuit = samples.size() - 1;
      if (i % by_circuit == 0) {
        writer_.roll_over();
        writer_.comment("Circuit " + std::to_string(i / by_circuit + 1) + " of " + std::to_string(N));
      }
      writer_.move(moves[i]);
    }
    writer_.roll_over();
  }

  // Times of moves, and whether the machine can make them.
  void run(std::vector<MachineMove>& moves, std::size_t index, VesselLayerReport& report) {
    require_travel(moves, index);
    const auto clamped =
        set_times(moves, at_, profile_, winding_.feed_mm_per_min / 60, over_speed_, index + 1);
    report.clamped.insert(report.clamped.end(), clamped.begin(), clamped.end());
    for (const MachineMove& move : moves) report.asked_time_s += move.time_s;
    report.time_s += trapezoidal_time_s(moves, at_, profile_);
    at_ = moves.back().to;
  }

  void require_travel(const std::vector<MachineMove>& moves, std::size_t index) const {
    for (std::size_t i = 0; i < winder_axes; ++i) {
      const auto& axis = profile_.axes[i];
      if (!axis || (static_cast<WinderAxis>(i) == WinderAxis::mandrel && profile_.roll_over)) continue;
      double low = 1e300, high = -1e300;
      for (const MachineMove& move : moves) {
        low = std::min(low, move.to[i]);
        high = std::max(high, move.to[i]);
      }
      if (low >= axis->lowest && high <= axis->highest) continue;
      throw Error(ErrorCode::no_path, layer_place(index + 1),
                  std::string(axis_names[i]) + " would travel from " + significant_text(low, 6) + " to " +
                      significant_text(high, 6) + ", the machine's goes from " +
                      significant_text(axis->lowest, 6) + " to " + significant_text(axis->highest, 6) +
                      "; move the mandrel, or give a smaller clearance");
    }
  }

  const VesselWinding& winding_;
  const MachineProfile& profile_;
  OverSpeed over_speed_;
  MachineWriter writer_;
  std::shared_ptr<const Meridian> mandrel_;
  std::optional<PayoutEye> eye_;
  AxisValues at_{};
  bool placed_ = false;
};

}  // namespace

VesselPattern layer_pattern(const Meridian& meridian, const WindTow& tow, const VesselLayer& layer,
                            std::size_t number) {
  const VesselQuery query = query_of(layer, tow);
  const std::vector<VesselPattern> found = find_vessel_patterns(meridian, query);
  if (found.empty()) throw Error(ErrorCode::no_path, layer_place(number), patterns_refusal(meridian, query));
  for (const VesselPattern& pattern : found) {
    if (pattern.circuits == layer.circuits.value_or(pattern.circuits) &&
        pattern.stride == layer.stride.value_or(pattern.stride))
      return pattern;
  }
  throw Error(
      ErrorCode::no_path, layer_place(number),
      "no pattern that closes near this angle has these circuits and stride; the first that does has " +
          std::to_string(found.front().circuits) + " and " + std::to_string(found.front().stride) +
          " (afptraj wind patterns lists all)");
}

SteeringRule hoop_rule(double angle_deg, const WindTow& tow) {
  const double half_a_turn = std::acosh(1 / std::sin(radians(angle_deg))) / std::numbers::pi;
  return {half_a_turn, {}, {}, tow.width_mm, true};
}

VesselPattern hoop_pattern(const Meridian& meridian, const WindTow& tow, std::size_t number) {
  const PassMaker stretch(meridian, {});
  const double R = meridian.at(meridian.widest()).r_mm;
  const double between =
      meridian.at(stretch.widest_last_t()).z_mm - meridian.at(stretch.widest_first_t()).z_mm - tow.width_mm;
  if (between < tow.width_mm) {
    throw Error(
        ErrorCode::no_path, layer_place(number),
        "the mandrel's cylinder is shorter than two tows, and hoops hold nowhere else; leave the layer out");
  }
  VesselPattern pattern;
  pattern.circuits = 1;
  pattern.starts = 1;
  const double pitch = between / std::ceil(between / tow.width_mm);
  pattern.angle_deg = degrees(std::atan2(2 * std::numbers::pi * R, pitch));
  const PassMaker passes(meridian, hoop_rule(pattern.angle_deg, tow));
  const std::optional<SteeredPass> found = passes.at(pattern.angle_deg);
  if (!found) throw Error(ErrorCode::no_path, layer_place(number), passes.refusal(pattern.angle_deg));
  pattern.turn_deg = 2 * degrees(found->pass.turn_rad());
  pattern.length_mm = 2 * found->pass.length_mm();
  pattern.opening_first_mm = pattern.opening_last_mm = R;
  pattern.ratio_first = found->ratio_first;
  pattern.ratio_last = found->ratio_last;
  pattern.overlap = tow.width_mm / pitch - 1;
  return pattern;
}

VesselReport write_vessel_program(const VesselWinding& winding, const MachineProfile& profile,
                                  OverSpeed over_speed, const MachineWriter::Sink& sink) {
  return VesselPlanner(winding, profile, over_speed, sink).write();
}

}  // namespace afptraj
