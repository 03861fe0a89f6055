#include "winding/grown_mandrel.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "geometry/error.h"
#include "winding/quadrature.h"

namespace afptraj {
namespace {

// Rows of a piece, by its length over the widest radius and twice what it bends: its spline's error is of
// fourth order in their distance, 1e-8 of the radius.
constexpr double rows_by_measure = 16;
constexpr int fewest_rows = 8, most_rows = 193;
constexpr double straight_mm = 1e-9;

double way_mm(const Meridian& meridian, double from, double to) {
  const std::vector<double>& breaks = meridian.breaks();
  double sum = 0, at = std::min(from, to);
  const double end = std::max(from, to);
  for (auto next = std::upper_bound(breaks.begin(), breaks.end(), at); at < end; ++next) {
    const double stop = next == breaks.end() ? end : std::min(*next, end);
    sum += gauss_legendre([&](double t) { return meridian.at(t).speed(); }, at, stop);
    at = stop;
  }
  return sum;
}

// The place `way` mm from another, forward or back, or the meridian's end.
double place_at(const Meridian& meridian, double from, double way, bool forward) {
  double near = from, far = forward ? meridian.last() : meridian.first();
  if (way_mm(meridian, from, far) <= way) return far;
  for (int i = 0; i < 60; ++i) {
    const double middle = (near + far) / 2;
    (way_mm(meridian, from, middle) < way ? near : far) = middle;
  }
  return (near + far) / 2;
}

// Distances from a turn below two tows level off to one and a half, smoothly.
double levelled(double distance, double tow) {
  if (distance >= 2 * tow) return distance;
  if (distance <= tow) return 1.5 * tow;
  return 1.5 * tow + (distance - tow) * (distance - tow) / (2 * tow);
}

// Where the rows of a piece are taken: evenly by the measure of `rows_by_measure`, just inside of its ends.
std::vector<double> row_places(const Meridian& meridian, double from, double to) {
  constexpr int samples = 512;
  const double radius = meridian.at(meridian.widest()).r_mm,
               beside = 1e-12 * (meridian.last() - meridian.first());
  std::vector<double> ts{from + beside}, measures{0};
  for (int i = 1; i <= samples; ++i) {
    const double step = (to - from) / samples;
    const MeridianPoint at = meridian.at(from + step * (i - 0.5));
    ts.push_back(i == samples ? to - beside : from + step * i);
    measures.push_back(measures.back() + step * at.speed() * (1 / radius + 2 * std::abs(at.curvature())));
  }
  const int count =
      std::clamp(static_cast<int>(std::ceil(rows_by_measure * measures.back())), fewest_rows, most_rows);
  std::vector<double> out{ts.front()};
  std::size_t k = 1;
  for (int i = 1; i + 1 < count; ++i) {
    const double wanted = measures.back() * i / (count - 1);
    while (measures[k] < wanted) ++k;
    const double share = (wanted - measures[k - 1]) / (measures[k] - measures[k - 1]);
    out.push_back(ts[k - 1] + share * (ts[k] - ts[k - 1]));
  }
  out.push_back(ts.back());
  return out;
}

// Rows through which a straight line goes are told by their ends.
std::vector<MeridianRow> without_needless(const std::vector<MeridianRow>& rows) {
  const MeridianRow &a = rows.front(), &b = rows.back();
  const double dz = b.z_mm - a.z_mm, dr = b.r_mm - a.r_mm, length = std::hypot(dz, dr);
  const bool straight = std::all_of(rows.begin(), rows.end(), [&](const MeridianRow& p) {
    return std::abs((p.z_mm - a.z_mm) * dr - (p.r_mm - a.r_mm) * dz) <= straight_mm * length;
  });
  return straight ? std::vector<MeridianRow>{a, b} : rows;
}

}  // namespace

LayerGrowth helical_growth(const Meridian& meridian, const FibrePass& pass, std::int64_t circuits,
                           const WindTow& tow) {
  const double w = tow.width_mm;
  const double spread = static_cast<double>(circuits) * w * tow.thickness_mm / std::numbers::pi;
  const auto plain = [&meridian, &pass, spread](double t) {
    const double r = meridian.at(t).r_mm, q = pass.clairaut_at(t);
    return spread / std::sqrt(std::max(r * r - q * q, 1e-12));
  };
  // The turns; of a pass that meets itself half-way the farther counts.
  const double first = pass.first().t, last = pass.last().t;
  const double middle = place_at(meridian, first, way_mm(meridian, first, last) / 2, true);
  LayerGrowth growth;
  growth.thickness_mm = [&meridian, plain, first, last, middle, w](double t) {
    const bool near_first = t < middle;
    const double turn = near_first ? first : last;
    const bool beyond = near_first ? t < turn : t > turn;
    const double distance = beyond ? 0 : way_mm(meridian, turn, t);
    if (distance >= 2 * w) return plain(t);
    const double inner = near_first
                             ? std::min(place_at(meridian, turn, levelled(distance, w), true), middle)
                             : std::max(place_at(meridian, turn, levelled(distance, w), false), middle);
    return plain(inner);
  };
  for (const double tows : {1.0, 2.0}) {
    growth.kinks.push_back(place_at(meridian, first, tows * w, true));
    growth.kinks.push_back(place_at(meridian, last, tows * w, false));
  }
  // where steering begins
  std::set_difference(pass.breaks().begin(), pass.breaks().end(), meridian.breaks().begin(),
                      meridian.breaks().end(), std::back_inserter(growth.kinks));
  return growth;
}

LayerGrowth hoop_growth(const Meridian& meridian, double first_t, double last_t, const WindTow& tow) {
  const double height = 2 * tow.thickness_mm, beside = 1e-9 * (meridian.last() - meridian.first());
  // A cosine of height h over a way l bends by h pi^2 / (2 l^2): half of the dome's bend is left.
  const auto fade_mm = [&](double t) {
    const double bend = std::max(meridian.at(t).curvature(), 0.0);
    const double convex = bend > 0 ? std::numbers::pi * std::sqrt(height / bend) : 0;
    return std::max(convex, 2 * tow.width_mm);
  };
  const double before = fade_mm(first_t - beside), after = fade_mm(last_t + beside);
  LayerGrowth growth;
  growth.thickness_mm = [&meridian, first_t, last_t, height, before, after](double t) {
    if (t >= first_t && t <= last_t) return height;
    const double share =
        t < first_t ? way_mm(meridian, t, first_t) / before : way_mm(meridian, last_t, t) / after;
    return share >= 1 ? 0.0 : height * (1 + std::cos(std::numbers::pi * share)) / 2;
  };
  growth.kinks = {first_t, last_t, place_at(meridian, first_t, before, false),
                  place_at(meridian, last_t, after, true)};
  return growth;
}

Meridian grown_mandrel(const Meridian& meridian, const LayerGrowth& growth) {
  std::vector<double> joints{meridian.first(), meridian.last()};
  double start = 0;
  for (const BSplineCurve2& piece : meridian.pieces()) {
    start += piece.last() - piece.first();
    joints.push_back(std::min(start, meridian.last()));
  }
  for (const double t : growth.kinks) joints.push_back(std::clamp(t, meridian.first(), meridian.last()));
  std::sort(joints.begin(), joints.end());
  std::vector<MeridianRow> rows;
  double from = joints.front();
  for (const double to : joints) {
    // what is shorter than the tolerance of steps along the fibre is no piece of its own
    if (way_mm(meridian, from, to) < 1e-3) continue;
    std::vector<MeridianRow> piece;
    for (const double t : row_places(meridian, from, to)) {
      const MeridianPoint at = meridian.at(t);
      const double out = growth.thickness_mm(t) / at.speed();
      piece.push_back({at.z_mm - out * at.dr, std::max(at.r_mm + out * at.dz, 0.0)});
    }
    piece = without_needless(piece);
    if (!rows.empty()) piece.front() = rows.back();  // one corner, that stands twice
    rows.insert(rows.end(), piece.begin(), piece.end());
    from = to;
  }
  try {
    return meridian_through(rows);
  } catch (const Error& e) {
    throw Error(ErrorCode::no_path, "mandrel", std::string("grown by the layers below ") + e.what());
  }
}

}  // namespace afptraj
