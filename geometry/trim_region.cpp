#include "geometry/trim_region.h"

#include "geometry/trim_crossing.h"
#include "geometry/trim_segments.h"

namespace afptraj {

UvCubic UvCubic::hermite(const Uv& p0, const Uv& d0, const Uv& p1, const Uv& d1) {
  const Uv e = p1 - p0;
  return {p0, d0, 3 * e - 2 * d0 - d1, d0 + d1 - 2 * e};
}

UvCubic UvCubic::line(const Uv& p0, const Uv& p1) { return {p0, p1 - p0, Uv::Zero(), Uv::Zero()}; }

struct TrimRegion::Data {
  trim::SegmentGrid grid;
};

TrimRegion::TrimRegion(const Face& face, double flatten_uv)
    : data_(std::make_shared<const Data>(Data{trim::SegmentGrid(face, flatten_uv)})) {}

bool TrimRegion::contains(const Uv& uv) const { return data_->grid.contains(data_->grid.scaled(uv)); }

TrimRegion::BoxState TrimRegion::classify(const Uv& lo, const Uv& hi) const {
  const trim::SegmentGrid& grid = data_->grid;
  int i0, i1, j0, j1;
  if (!grid.cells(grid.scaled(lo), grid.scaled(hi), i0, i1, j0, j1)) return BoxState::outside;
  if (grid.mixed_count(i0, i1, j0, j1) > 0) return BoxState::mixed;
  return grid.cell_state(i0, j0) == trim::CellState::inside ? BoxState::inside : BoxState::outside;
}

std::vector<LoopCrossing> TrimRegion::crossings(const UvCubic& path) const {
  return trim::CrossingSearch(data_->grid, path).run();
}

std::optional<LoopCrossing> TrimRegion::first_crossing(const UvCubic& path, bool outward) const {
  const std::vector<LoopCrossing> found = trim::CrossingSearch(data_->grid, path).run(true, outward);
  if (found.empty()) return std::nullopt;
  return found.front();
}

LoopCrossing TrimRegion::nearest(const Uv& uv, const Eigen::Matrix2d& metric) const {
  const trim::SegmentGrid& grid = data_->grid;
  const Uv unscale = grid.scale.cwiseInverse();
  const Eigen::Matrix2d scaled_metric = unscale.asDiagonal() * metric * unscale.asDiagonal();
  return trim::nearest_on_loops(grid, grid.scaled(uv), scaled_metric);
}

Uv TrimRegion::box_min() const { return data_->grid.box_lo; }
Uv TrimRegion::box_max() const { return data_->grid.box_hi; }

}  // namespace afptraj
