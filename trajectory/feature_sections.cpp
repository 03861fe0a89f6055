#include "trajectory/feature_sections.h"

#include <algorithm>
#include <cmath>

#include <tbb/parallel_for.h>

namespace afptraj {

FeatureSections feature_sections(const Skin& skin, const SourceCurve& path, double band_width_mm, double spacing_mm) {
  const double length = path.last() - path.first();
  const auto count = static_cast<std::size_t>(std::clamp(std::ceil(length / spacing_mm), 1.0, 200.0));
  SectionOptions options;
  options.step_mm = std::max(5.0, skin.diagonal() / 400);
  options.tolerance_mm = 1e-4;
  std::vector<double> left(count + 1, 0.0), right(count + 1, 0.0);
  tbb::parallel_for(std::size_t{0}, count + 1, [&](std::size_t i) {
    const SourceCurve::Frame q = path.at(path.first() + length * static_cast<double>(i) / static_cast<double>(count));
    if (q.outside) return;
    const Plane plane{q.frame.position, q.frame.tangent};
    const SectionCurve to_left = trace_section(skin, plane, q.at, q.frame.left(), options);
    left[i] = to_left.length_mm();
    if (to_left.closed) {  // round a tube: each side goes half way, where it meets the other
      left[i] *= 0.5;
      right[i] = left[i];
      return;
    }
    right[i] = trace_section(skin, plane, q.at, -q.frame.left(), options).length_mm();
  });
  FeatureSections out;
  out.L1_mm = *std::max_element(left.begin(), left.end());
  out.L2_mm = *std::max_element(right.begin(), right.end());
  const auto bands = [&](double L) {
    return std::max(0, static_cast<int>(std::ceil((L - band_width_mm / 2) / band_width_mm - 1e-9)));
  };
  out.N1 = bands(out.L1_mm);
  out.N2 = bands(out.L2_mm);
  return out;
}

}  // namespace afptraj
