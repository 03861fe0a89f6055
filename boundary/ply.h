#pragma once

#include <string>
#include <vector>

#include "boundary/tow_lines.h"
#include "geometry/types.h"

namespace afptraj {

/// A sample of a course's centre line with its Darboux frame (t, n, b = n x t, left).
struct CourseSample {
  SurfacePoint at;
  double s_mm = 0;  ///< arc length from the start of the segment
  Vec3 position = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();
  Vec3 tangent = Vec3::UnitX();
  double kn_per_mm = 0;      ///< normal curvature, positive toward n
  double kg_per_mm = 0;      ///< geodesic curvature, positive to the left
  double deviation_rad = 0;  ///< signed angle from the asked direction to t about n, in (-pi/2, pi/2]
};

/// A stretch of a course on the skin, from boundary to boundary (or corner, or pole).
struct CourseSegment {
  std::vector<CourseSample> samples;
  bool closed = false;
  double length_mm() const { return samples.empty() ? 0 : samples.back().s_mm; }
};

/// One pass of the head: course 0 is the reference, +1, +2 ... lie to its left, -1 ... to its right.
struct Course {
  int number = 0;
  std::vector<CourseSegment> segments;
  double length_mm() const;
};

/// A sample of the middle line of a tow, with its frame.
struct TowSample {
  SurfacePoint at;
  double s_mm = 0;  ///< arc length from where the piece is added
  Vec3 position = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();
  Vec3 tangent = Vec3::UnitX();
  double kg_per_mm = 0;  ///< geodesic curvature, positive to the left
  bool on_skin = true;   ///< false where it lies on the continuation of the skin, or over a hole
};

/// A piece of a tow, from where it is added to where it is cut.
struct TowPiece {
  int course = 0;
  int tow = 1;           ///< 1 ... N from the left
  int segment = 1;       ///< counted along the tow
  std::size_t band = 0;  ///< of Ply::bands
  Interval range;        ///< of the band's parameter; on a closed band it may end beyond `last`, which is `first` again
  bool closed = false;   ///< a whole turn
  std::vector<TowSample> samples;
  double length_mm() const { return samples.empty() ? 0 : samples.back().s_mm; }
};

/// The tightest turn of a tow on the skin.
struct TightestTurn {
  double radius_mm = 1e12;  ///< no machine can tell it from straight
  int course = 0, tow = 0;
  Vec3 where = Vec3::Zero();
};

/// What the tows came to.
struct TowReport {
  int tows = 0;  ///< with at least one piece
  int pieces = 0, adds = 0, cuts = 0;
  int bridged = 0, extended = 0, dropped = 0;  ///< by minimum gap and minimum cut length
  double length_mm = 0, shortest_mm = 0, longest_mm = 0;
  TightestTurn tightest;
};

/// A polygon of one face that no tow covers, or that tows cover more than once.
struct TowSpot {
  int layers = 0;  ///< tows that lie over each other; 0 is a gap
  double area_mm2 = 0, length_mm = 0, width_mm = 0;  ///< length: greatest extent; width: the greatest across it
  Vec3 where = Vec3::Zero();                         ///< the middle of the widest place
  std::vector<std::pair<int, int>> tows;             ///< course and tow, of those at its edge
  bool at_boundary = false;                          ///< the boundary of its face is part of its edge
  int face = -1;
  std::vector<Uv> outline;  ///< its outer boundary in (u, v), anticlockwise
  bool gap() const { return layers == 0; }
};

/// What the tows cover, from polygons. Areas are of the skin.
struct TowCoverage {
  bool measured = false;
  double skin_mm2 = 0;      ///< within the loops of the faces
  double covered_mm2 = 0, gap_mm2 = 0;
  double overlap_mm2 = 0;   ///< counted once for every layer above the first
  double laid_mm2 = 0;      ///< all tows, with what lies off the skin: by the lengths of their lines
  double off_skin_mm2 = 0;  ///< of these
  double error_mm2 = 0;     ///< bounds the error of skin, covered, gap and overlap
  double laid_error_mm2 = 0;  ///< ... of laid and off skin
  /// skin - covered - gap, and laid - off skin - overlap - covered, each from areas found apart: at most `error_mm2`, and
  /// `error_mm2` + `laid_error_mm2`, where the polygons are right.
  double skin_residual_mm2 = 0, laid_residual_mm2 = 0;
  std::vector<TowSpot> spots;  ///< by area, greatest first; slivers narrower than the lines' tolerance are left out
  bool holds() const;          ///< both residuals are within their bounds
};

/// A stretch of the skin farther than W/2 from every centre line, and why.
struct UncoveredSpot {
  Vec3 where = Vec3::Zero();  ///< the worst point
  double area_mm2 = 0;
  double distance_mm = 0;     ///< from the worst point to the nearest centre line
  std::string reason;
};

/// E_k, the greatest |distance to the neighbouring course - W| over points between samples.
struct SpacingError {
  double worst_mm = 0;
  int worst_course = 0;
  Vec3 where = Vec3::Zero();
  std::size_t measured = 0;
  std::size_t beyond_end = 0;  ///< the neighbour's foot lies past its end on the boundary: nothing to measure
  std::size_t unresolved = 0;  ///< no way to the neighbour was found
  Vec3 first_unresolved = Vec3::Zero();
  std::size_t off_skin = 0;  ///< in error, but the way to the neighbour runs over places without material
  double off_skin_worst_mm = 0;
};

/// A place where the centre lines of two courses, or of one, cross.
struct CourseCrossing {
  int course = 0, other = 0;
  Vec3 where = Vec3::Zero();
};

/// An end of a centre line inside the skin that meets no other.
struct LooseEnd {
  int course = 0;
  Vec3 where = Vec3::Zero();
};

/// Wall time of one stage of planning.
struct StageTime {
  std::string stage;
  double seconds = 0;
};

/// What was reached, beside the courses themselves.
struct PlyReport {
  double band_width_mm = 0;
  // reference path
  double reference_length_mm = 0;
  std::size_t reference_points = 0;
  double fit_rms_mm = 0, fit_max_mm = 0;
  double reference_closed_over_mm = 0;  ///< how far beside its start it came back before it was closed
  double range_doubled_share = 0;  ///< share of steps with no ply point in range at first
  std::string reference_end[2];    ///< why it ended, backward and forward
  // feature sections
  double L1_mm = 0, L2_mm = 0;
  int N1 = 0, N2 = 0;
  int courses_left = 0, courses_right = 0;
  std::string courses_reason;      ///< where laid and computed numbers differ
  // judged on the result
  double total_length_mm = 0;
  double skin_area_mm2 = 0;
  double covered_share = 0;        ///< of the skin within W/2 of a centre line
  double reached_share = 0;        ///< with the bands whose centre line runs off the skin
  std::vector<UncoveredSpot> uncovered;
  double spacing_error_mm = 0;     ///< E_k, greatest over the courses, between output samples
  SpacingError spacing;            ///< ... in full
  std::vector<CourseCrossing> crossings;
  std::vector<LooseEnd> loose_ends;
  double min_steering_radius_mm = 0;
  double max_deviation_rad = 0;
  TowReport tows;
  TowCoverage tow_coverage;
  std::vector<std::string> warnings;
  std::vector<std::string> violations;  ///< limits of the job that do not hold
  std::vector<StageTime> times;
};

/// All courses of one orientation, in the order of their numbers.
struct Ply {
  std::string name;
  std::vector<Course> courses;
  /// Centre lines off the skin (beyond its boundary, over holes) near enough that their bands may
  /// reach onto it, by the same numbers. They are no paths to lay as they stand; tows are cut from them.
  std::vector<Course> off_skin;
  /// Empty when tows were not asked for, or their lines not kept.
  std::vector<TowBand> bands;
  std::vector<TowPiece> tows;  ///< by course, tow, segment
  PlyReport report;
};

}  // namespace afptraj
