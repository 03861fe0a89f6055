#include "winding/simulate_program.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "winding/pattern.h"

namespace afptraj {
namespace {

// Circles on which coverage is looked at: eight in each width of the tow, within what memory bears.
int sections_of(const WindMandrel& mandrel, const WindTow& tow) {
  return static_cast<int>(std::clamp(std::ceil(8 * mandrel.length_mm / tow.width_mm), 64.0, 8192.0));
}

}  // namespace

std::int64_t SimulatedProgram::moves() const {
  std::int64_t sum = 0;
  for (const SimulatedLayer& layer : layers) sum += layer.moves;
  return sum;
}

double SimulatedProgram::length_mm() const {
  double sum = 0;
  for (const SimulatedLayer& layer : layers) sum += layer.laid_mm + layer.turned_mm;
  return sum;
}

double SimulatedProgram::time_s() const {
  double sum = 0;
  for (const SimulatedLayer& layer : layers) sum += layer.time_s;
  return sum;
}

ProgramSimulator::ProgramSimulator(const WindMandrel& mandrel, const WindTow& tow, KeepPieces keep)
    : keep_(keep) {
  result_.mandrel = mandrel;
  result_.tow = tow;
}

SimulatedLayer& ProgramSimulator::layer() {
  if (result_.layers.empty()) result_.layers.emplace_back();
  return result_.layers.back();
}

void ProgramSimulator::end_layer() {
  if (result_.layers.empty()) return;
  if (band_) layer().coverage = band_->coverage();
  layer().starts = static_cast<std::int64_t>(starts_deg_.size());
  layer().start_error_deg = uneven_deg(std::move(starts_deg_));
  band_.reset();
  starts_deg_.clear();
}

void ProgramSimulator::begin_layer(const std::string& name) {
  end_layer();
  result_.layers.emplace_back().name = name;
}

bool ProgramSimulator::move(std::optional<double> carriage_mm, std::optional<double> mandrel_deg,
                            std::optional<double> head_deg) {
  const AxisPosition to{carriage_mm.value_or(at_.carriage_mm), mandrel_deg.value_or(at_.mandrel_deg),
                        head_deg.value_or(at_.head_deg)};
  const double dx = to.carriage_mm - at_.carriage_mm, da = to.mandrel_deg - at_.mandrel_deg;
  if (dx == 0 && da == 0) {
    // the lines before the first layer only say where the axes are
    if (!result_.layers.empty() && to.head_deg == at_.head_deg) ++layer().idle_moves;
    at_ = to;
    return true;
  }
  if (!(feed_ > 0)) return false;
  SimulatedLayer& now = layer();
  const double length = std::hypot(dx, da / 360 * (std::numbers::pi * result_.mandrel.diameter_mm));
  ++now.moves;
  now.time_s += length / feed_ * 60;
  (dx == 0 ? now.turned_mm : now.laid_mm) += length;
  if (da < 0) ++now.backward_turns;
  const double from_deg = origin_deg_ + at_.mandrel_deg;
  if (dx > 0 && std::abs(at_.carriage_mm) < 1e-6) starts_deg_.push_back(from_deg);
  if (dx != 0 && !band_)
    band_.emplace(result_.mandrel, result_.tow.width_mm, sections_of(result_.mandrel, result_.tow));
  if (band_) band_->lay(at_.carriage_mm, from_deg, to.carriage_mm, from_deg + da);
  if (band_ && keep_ == KeepPieces::yes)
    keep_piece({at_.carriage_mm, from_deg, to.carriage_mm, from_deg + da});
  at_ = to;
  return true;
}

// Goes on with the last piece where that leads straight on, to a hundredth of a millimetre.
void ProgramSimulator::keep_piece(const LaidPiece& piece) {
  std::vector<LaidPiece>& pieces = layer().pieces;
  if (!pieces.empty() && pieces.back().z1_mm == piece.z0_mm &&
      std::abs(pieces.back().angle1_deg - piece.angle0_deg) < 1e-6) {
    LaidPiece& last = pieces.back();
    const double round = std::numbers::pi / 360 * result_.mandrel.diameter_mm;
    const double ax = last.z1_mm - last.z0_mm, ay = (last.angle1_deg - last.angle0_deg) * round;
    const double bx = piece.z1_mm - piece.z0_mm, by = (piece.angle1_deg - piece.angle0_deg) * round;
    // of an arc the chord and the direction at its end are so far apart as four times its height
    const double off = std::abs(ax * by - ay * bx) / std::hypot(bx, by) / 4;
    if (ax * bx + ay * by > 0 && off < 0.01) {
      last.z1_mm = piece.z1_mm;
      last.angle1_deg = piece.angle1_deg;
      return;
    }
  }
  pieces.push_back(piece);
}

void ProgramSimulator::declare(std::optional<double> carriage_mm, std::optional<double> mandrel_deg,
                               std::optional<double> head_deg) {
  if (mandrel_deg) origin_deg_ += at_.mandrel_deg - *mandrel_deg;
  at_ = {carriage_mm.value_or(at_.carriage_mm), mandrel_deg.value_or(at_.mandrel_deg),
         head_deg.value_or(at_.head_deg)};
}

SimulatedProgram ProgramSimulator::finish() {
  end_layer();
  return std::move(result_);
}

}  // namespace afptraj
