#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "winding/laid_band.h"
#include "winding/program_writer.h"

namespace afptraj {

/// A straight piece of a path: along the axis, and the mandrel's angle against the eye, unbounded.
struct LaidPiece {
  double z0_mm = 0, angle0_deg = 0, z1_mm = 0, angle1_deg = 0;
};
enum class KeepPieces { no, yes };

/// What the machine does between two layer comments.
struct SimulatedLayer {
  std::string name;                 ///< the comment without "Layer ": "1 of 2: hoop"
  std::int64_t moves = 0;           ///< lines on which the carriage or the mandrel moves
  std::int64_t idle_moves = 0;      ///< lines on which no axis moves
  std::int64_t backward_turns = 0;  ///< lines on which the mandrel turns back
  double laid_mm = 0;               ///< while the carriage travels
  double turned_mm = 0;             ///< while it stands
  double time_s = 0;
  std::int64_t starts = 0;               ///< passes that leave z = 0
  double start_error_deg = 0;            ///< greatest distance of a start from its place among 360 / starts
  std::optional<BandCoverage> coverage;  ///< of this layer alone; none where nothing was laid
  std::vector<LaidPiece> pieces;         ///< if they are kept; those that go on straight are one
};

struct SimulatedProgram {
  WindMandrel mandrel;
  WindTow tow;
  std::int64_t commands = 0;  ///< lines without the modal ones
  std::vector<SimulatedLayer> layers;

  std::int64_t moves() const;
  double length_mm() const;
  double time_s() const;
};

/// Does what a controller does with the lines of a program and rebuilds, layer by layer, the band that is
/// laid, from the axes alone: the tow lies at z = X and at the angle A against the eye.
class ProgramSimulator {
 public:
  ProgramSimulator(const WindMandrel& mandrel, const WindTow& tow, KeepPieces keep = KeepPieces::no);

  void begin_layer(const std::string& name);
  void count_command() { ++result_.commands; }
  void set_feed(double mm_per_min) { feed_ = mm_per_min; }
  /// Axes that are not given stay. False, and nothing done, when there is way to go and no feed yet.
  [[nodiscard]] bool move(std::optional<double> carriage_mm, std::optional<double> mandrel_deg,
                          std::optional<double> head_deg);
  /// "G92"
  void declare(std::optional<double> carriage_mm, std::optional<double> mandrel_deg,
               std::optional<double> head_deg);
  SimulatedProgram finish();

 private:
  SimulatedLayer& layer();
  void end_layer();
  void keep_piece(const LaidPiece& piece);

  SimulatedProgram result_;
  KeepPieces keep_;
  AxisPosition at_;
  double origin_deg_ = 0;  // of the mandrel's axis
  double feed_ = 0;
  std::optional<LaidBand> band_;
  std::vector<double> starts_deg_;
};

}  // namespace afptraj
