#pragma once

#include <memory>
#include <vector>

#include "trajectory/laid_curves.h"
#include "trajectory/source_curve.h"

namespace afptraj {

/// How the rays of a front are spaced, and what the level curves must hold.
struct FrontOptions {
  double spacing_mm = 50.8;            ///< W, between levels
  double sample_mm = 4;                ///< greatest distance of neighbouring rays
  double hermite_tolerance_mm = 1e-5;  ///< estimated error of the cubic between rays
  double extension_step_mm = 5;
  double max_extension_mm = 1e6;
  double extension_margin_mm =
      0;  ///< how far an extension goes beyond the natural domain; rays: the tracer's
  double validity_tolerance_mm =
      2e-4;  ///< a point is kept if no curve is nearer than W minus this: what Hermite
             ///< curves and joined faces may be off; meetings themselves are solved
};

/// A geodesic shot at a right angle from parameter `t` of a source curve.
struct Ray {
  double t = 0;
  GeodesicState state;
};

/// Why a strand ends where it does.
enum class StrandEnd {
  open,     ///< the rays beyond left the skin
  corner,   ///< two fronts meet here
  stopped,  ///< the rays beyond are nearer to another curve, whose front has left the skin
  linked,   ///< the next strand goes on here, from another source
};

/// A run of neighbouring rays of one source.
struct Strand {
  int source = 0;
  std::vector<Ray> rays;
  StrandEnd end[2] = {StrandEnd::open, StrandEnd::open};
  int link[2] = {-1, -1};     ///< same number: linked ends
  int meeting[2] = {-1, -1};  ///< while the front is trimmed: the meeting at an end
  int fresh_end = -1;         ///< of an extension at the level it was made: the end it starts from
  bool trimmed = false;       ///< all of it has passed trim_fronts at this level
  int parent = -1;            ///< laid curve of the level before ...
  double parent_offset = 0;   ///< ... and how its parameter follows from a ray's: t + offset
};

/// A source curve and the level it belongs to: its rays have walked (level - birth) W.
struct FrontSource {
  std::shared_ptr<const SourceCurve> curve;
  int birth = 0;
  bool wide = false;  ///< its rays may go farther outside (Front::wide_tracer)
};

/// One side of a family of geodesic parallels: the rays, level by level.
///
/// At each level: all rays walk W; those that leave the skin end, and the front ends there exactly;
/// rays are added where neighbours part. trim_fronts (trim_front.h) then cuts both sides where fronts meet.
/// Where an end lies inside the skin because the level before ended at a boundary, or at a focal
/// point beyond which no ray leads, the level curve goes on along its own geodesic, which becomes a
/// source of rays itself.
class Front {
 public:
  /// `side` +1: left of the sources, -1: right.
  Front(const GeodesicTracer& tracer, int side, const FrontOptions& options);

  int side() const { return side_; }
  const GeodesicTracer& tracer() const { return *tracer_; }
  /// Less exact and faster: accurate to a tenth of the validity tolerance.
  const GeodesicTracer& probe_tracer() const { return probe_tracer_; }
  /// For fronts that come back from outside (lost_fronts.h): beyond the part by up to 2.5 W.
  const GeodesicTracer& wide_tracer() const { return wide_tracer_; }
  const Skin& skin() const { return tracer_->skin(); }
  const FrontOptions& options() const { return options_; }
  const std::vector<Strand>& strands() const { return strands_; }
  std::vector<Strand>& strands() { return strands_; }
  const FrontSource& source(int index) const { return sources_[static_cast<std::size_t>(index)]; }
  bool empty() const { return strands_.empty(); }

  int add_source(std::shared_ptr<const SourceCurve> curve, int birth, bool wide = false);
  void add_strand(Strand strand) { strands_.push_back(std::move(strand)); }

  /// The ray from parameter t of a source, walked up to `level`; `alive` is false if it left the skin.
  Ray shoot(int source, double t, int level, bool* alive) const;

  /// Refines the strands of level 0 like those of any level.
  void refine_level_zero();

  /// Takes over the sources and strands of level 0 of the other side: the same places, rays turned round.
  void mirror(const Front& other);

  /// Walks all rays from `level` - 1 to `level`, ends strands where rays left the skin, refines.
  void advance(int level);

  /// Goes on past the open ends inside the skin until the path leaves it, winds round, comes nearer
  /// than W to a curve of a lower level (`laid`), or runs ahead of another curve of this level on the
  /// same side (`current`), which will lay that place itself. What of it holds is for trim_fronts to say.
  void extend(int level, const LaidCurves& laid, const LaidCurves& current, int& next_link);

  /// Adds rays where neighbours part or the cubic between them would miss the level curve, and
  /// drops rays that have come too close together; the ends stay.
  void refine(Strand& strand, int level) const;

  /// Whether another end shares the link of this one.
  bool has_partner(std::size_t strand, int end) const;

  /// The runs of rays still on the skin; each new end is moved to the last place whose ray is.
  std::vector<Strand> alive_runs(const Strand& strand, const std::vector<char>& alive, int level) const;

  /// Links end `e` of a strand with the other end of the strand that goes on there.
  static void join(Strand& strand, int e, Strand& next, int link);

  /// A link holds only while both of its ends do; else they are open.
  void settle_links();

 private:
  const GeodesicTracer& tracer_of(int source) const {
    return sources_[static_cast<std::size_t>(source)].wide ? wide_tracer_ : *tracer_;
  }
  void split_where_rays_part(Strand strand, std::vector<Strand>& out) const;
  Strand extension_strand(const std::vector<GeodesicState>& states, bool backward, int level);
  GeodesicState onward(const Ray& end, bool backward) const;
  bool too_near(const PathFrame& at, const LaidCurves& laid) const;
  std::vector<GeodesicState> extension(const Ray& end, bool backward, int level, const LaidCurves& laid,
                                       const LaidCurves& current,
                                       const std::vector<std::vector<GeodesicState>>& made,
                                       bool* stopped) const;
  bool runs_ahead(const PathFrame& at, const LaidCurves& current) const;

  const GeodesicTracer* tracer_;
  GeodesicTracer extension_tracer_, wide_tracer_, probe_tracer_;
  int side_;
  FrontOptions options_;
  std::vector<FrontSource> sources_;
  std::vector<Strand> strands_;
};

/// The node of a level curve at a ray: tangent and speed by Gauss's lemma and the Jacobi field.
CurveNode level_node(const Skin& skin, const SourceCurve& source, const Ray& ray, int side);

/// Whether two neighbouring nodes lie on one chart with a smooth cubic between them.
bool same_chart(const Skin& skin, const CurveNode& a, const CurveNode& b);

}  // namespace afptraj
