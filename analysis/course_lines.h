#pragma once

#include <vector>

#include "boundary/ply.h"
#include "geometry/skin.h"
#include "geometry/surface_curve.h"

namespace afptraj {

/// A segment of a course as the judge sees it: the curve through its samples, and its chords (from
/// sample to sample).
struct CourseLine {
  int course = 0;
  bool off_skin = false;
  SurfaceCurve curve;
  std::vector<double> t;      ///< of the curve, by sample
  std::vector<Vec3> points;   ///< by sample
  std::vector<Vec3> normals;  ///< by sample
  struct Chord {
    std::size_t piece, node;
  };
  std::vector<Chord> chords;  ///< where a chord's cubic is found in the curve

  bool closed() const { return curve.closed; }
  std::size_t chord_count() const { return chords.size(); }
  /// The point of the curve itself over x in [0, 1] of a chord.
  CurveFrame frame(const Skin& skin, std::size_t chord, double x) const {
    return frame_at(skin, curve.pieces[chords[chord].piece], chords[chord].node, x);
  }
  double t_at(std::size_t chord, double x) const { return (1 - x) * t[chord] + x * t[chord + 1]; }
};

/// The lines of a ply, in its order, those off the skin last. Segments without length are left out.
std::vector<CourseLine> course_lines(const Skin& skin, const Ply& ply);

}  // namespace afptraj
