#include <algorithm>
#include <cmath>
#include <numbers>

#include "winding/fixed_text.h"
#include "winding/frustum.h"
#include "winding/layers.h"
#include "winding/pattern.h"

namespace afptraj {
namespace {

constexpr double turned_head_deg = 10;  // of the head while it waits at an end
// On a cylinder in two straight pieces, on a cone in stations of about a millimetre.
enum class Way { there, back };

class HelicalWriter {
 public:
  HelicalWriter(ProgramWriter& writer, const WindDefinition& definition, const HelicalLayer& layer,
                std::int64_t circuits)
      : writer_(writer),
        layer_(layer),
        native_(writer.mode() == WindMode::native),
        length_(definition.mandrel.length_mm),
        circuits_(circuits) {
    if (definition.mandrel.is_cone()) {
      cone_.emplace(definition.mandrel, layer.angle_deg);
      turn_per_pass_ = cone_->turn_deg(length_);
    } else {
      const double circumference = std::numbers::pi * definition.mandrel.diameter_mm;
      turn_per_pass_ = 360 * (length_ * std::tan(radians(layer.angle_deg)) / circumference);
    }
    fill_ = layer.lock_deg - layer.lead_out_deg - modulo(turn_per_pass_, 360);
    if (native_ && fill_ < 0) fill_ = modulo(fill_, 360);  // on to the same place, not back
  }

  void write() {
    if (!layer_.skip_initial_near_lock) {
      writer_.set_purpose(MovePurpose::reposition);
      writer_.move_to({0, layer_.lock_deg, 0});
      writer_.set_position({}, 0.0, {});
    }
    const double p = static_cast<double>(layer_.pattern);
    const std::int64_t patterns = circuits_ / layer_.pattern;
    const double step = 360 * (1 / static_cast<double>(circuits_));
    for (std::int64_t q = 1; q <= patterns; ++q) {
      for (std::int64_t c = 1; c <= layer_.pattern; ++c) {
        begin_circuit(q, patterns, c);
        pass(Way::there);
        pass(Way::back);
        mandrel_ += static_cast<double>(layer_.skip) * 360 / p;
      }
      mandrel_ += step;
    }
    writer_.set_purpose(MovePurpose::reposition);
    mandrel_ += layer_.lock_deg;
    turn_to(0);
    write_zero(writer_, mandrel_);
  }

 private:
  void begin_circuit(std::int64_t pattern, std::int64_t patterns, std::int64_t circuit) {
    writer_.comment(std::string(native_ ? "" : "\t") + "Pattern: " + std::to_string(pattern) + "/" +
                    std::to_string(patterns) + " Circuit: " + std::to_string(circuit) + "/" +
                    std::to_string(layer_.pattern));
    if (!native_ || mandrel_ < 360) return;
    // Whole turns are taken off, for controllers that hold positions in single precision. A whole number
    // off changes no decimal, so nothing is lost by it.
    const double turns = std::floor(mandrel_ / 360) * 360;
    mandrel_ -= turns;
    writer_.set_position({}, writer_.position().mandrel_deg - turns, {});
  }

  // The carriage stays.
  void turn_to(double head_deg) { writer_.move_to({writer_.position().carriage_mm, mandrel_, head_deg}); }

  void pass(Way way) {
    const double sign = way == Way::there ? 1 : -1;
    writer_.set_purpose(MovePurpose::turn_around);
    turn_to(0);
    turn_to(-turned_head_deg * sign);
    writer_.set_purpose(MovePurpose::lay);
    if (cone_) {
      lay_on_cone(way, sign);
    } else {
      lay_on_cylinder(way, sign);
    }
    writer_.set_purpose(MovePurpose::turn_around);
    mandrel_ += layer_.lead_out_deg;
    turn_to(-turned_head_deg * sign);
    mandrel_ += fill_;
  }

  void lay_on_cylinder(Way way, double sign) {
    const double per_mm = turn_per_pass_ / length_;
    const double head = -sign * (90 - layer_.angle_deg);
    mandrel_ += per_mm * layer_.lead_in_mm;
    writer_.move_to({way == Way::there ? layer_.lead_in_mm : length_ - layer_.lead_in_mm, mandrel_, head});
    mandrel_ += per_mm * (length_ - layer_.lead_in_mm);
    writer_.move_to({way == Way::there ? length_ : 0, mandrel_, head});
  }

  void lay_on_cone(Way way, double sign) {
    const double from = way == Way::there ? 0 : length_, to = way == Way::there ? length_ : 0;
    const double stations = std::max(1.0, std::nearbyint(length_));
    const double lift = -turned_head_deg * sign;
    double turned = cone_->turn_deg(from);
    for (double k = 1; k <= stations; ++k) {
      const double z = from + (to - from) * (k / stations);
      const double turn = cone_->turn_deg(z);
      mandrel_ += std::abs(turn - turned);
      turned = turn;
      const double ramp = std::min(1.0, std::abs(z - from) / layer_.lead_in_mm);
      const double target = -sign * (90 - cone_->angle_deg(z));
      writer_.move_to({z, mandrel_, lift + ramp * (target - lift)});
    }
  }

  ProgramWriter& writer_;
  const HelicalLayer& layer_;
  bool native_;
  double length_;
  std::int64_t circuits_;
  std::optional<ConeGeodesic> cone_;
  double turn_per_pass_ = 0, fill_ = 0;
  double mandrel_ = 0;  // where the mandrel is to be; the axis itself may lag behind
};

}  // namespace

void write_helical(ProgramWriter& writer, const WindDefinition& definition, const HelicalLayer& layer,
                   LayerReport& report) {
  report.circuits = circuits(definition.mandrel, definition.tow, layer, writer.mode());
  report.overlap = overlap(definition.mandrel, definition.tow, layer.angle_deg, report.circuits);
  HelicalWriter(writer, definition, layer, report.circuits).write();
}

void write_zero(ProgramWriter& writer, double mandrel_deg) {
  const double rest = modulo(mandrel_deg, 360);
  writer.set_purpose(MovePurpose::reposition);
  if (writer.mode() == WindMode::native && millionths(rest) % 360000000 == 0) {
    writer.set_position(0.0, 0.0, 0.0);
    return;
  }
  writer.set_position(0.0, rest, 0.0);
  writer.move_to({0, 360, 0});
  writer.set_position({}, 0.0, {});
}

}  // namespace afptraj
