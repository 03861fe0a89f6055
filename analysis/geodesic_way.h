#pragma once

#include <optional>

#include "analysis/course_lines.h"
#include "geometry/geodesic.h"

namespace afptraj {

/// How the judge's geodesics walk: a band's width past the skin's edges, holes crossed.
GeodesicOptions judge_geodesics(const Skin& skin, double band_width_mm, double tolerance_mm);

/// The geodesic from a line, at a right angle, to a point.
struct Way {
  enum class End {
    foot,        ///< found
    beyond_end,  ///< the foot lies past an end of the line
    failed,      ///< not solved, or it does not stay near the skin
  };
  End end = End::failed;
  double t = 0;            ///< of the line at the foot, or at the end
  double distance_mm = 0;  ///< its length
  double side = 1;         ///< 1: to the left of the line
};

/// Where the search for a way begins.
struct WaySeed {
  double t = 0, distance_mm = 0, side = 1;
};

/// Solves exp(line(t), d) = p by Newton-Raphson on (t, d), the Jacobi field as the Jacobian. A residual
/// that is small enough for its square not to count is corrected to first order.
Way way_from_line(const GeodesicTracer& tracer, const CourseLine& line, const WaySeed& seed, const Vec3& p);

/// The geodesic from a point of a line to p, by Newton-Raphson on its direction and length. Nothing when
/// it does not converge.
struct PointWay {
  double distance_mm = 0;
  bool leaves_skin = false;  ///< it passes over places without material
};
std::optional<PointWay> way_from_point(const GeodesicTracer& tracer, const CurveFrame& from, const Vec3& p,
                                       double distance_mm);

/// The same way by a search for the least distance over t in [t - reach, t + reach]: slow, but it does not mind a
/// focal point of the line's normals, where Newton-Raphson is led astray. Failed where the least lies at a limit.
Way way_by_search(const GeodesicTracer& tracer, const CourseLine& line, double t, double reach, const Vec3& p,
                  double distance_mm);

/// Whether a way passes over places without material.
bool leaves_skin(const GeodesicTracer& tracer, const CourseLine& line, const Way& way);

/// The way over the skin from a chord: exact on spheres, where normals that differ by a give
/// arc / chord = (a / 2) / sin(a / 2).
double arc_of(double chord_mm, double cosine_of_normals);

}  // namespace afptraj
