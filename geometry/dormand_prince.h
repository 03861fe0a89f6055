#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

/// One explicit step of an autonomous x' = f(x) with the pair of Dormand & Prince of order 8(5,3). Internal
/// to this room. At the tolerances of geodesics order 8 needs a third of the evaluations of order 5. Source:
/// Hairer, Norsett & Wanner, Solving ODEs I, II.5 and II.10 (DOP853).
namespace afptraj::dop853 {

constexpr int stages = 12;
constexpr double A[stages][stages] = {
    {},
    {5.26001519587677318785587544488e-2},
    {1.97250569845378994544595329183e-2, 5.91751709536136983633785987549e-2},
    {2.95875854768068491816892993775e-2, 0, 8.87627564304205475450678981324e-2},
    {2.41365134159266685502369798665e-1, 0, -8.84549479328286085344864962717e-1,
     9.24834003261792003115737966543e-1},
    {3.7037037037037037037037037037e-2, 0, 0, 1.70828608729473871279604482173e-1,
     1.25467687566822425016691814123e-1},
    {3.7109375e-2, 0, 0, 1.70252211019544039314978060272e-1, 6.02165389804559606850219397283e-2,
     -1.7578125e-2},
    {3.70920001185047927108779319836e-2, 0, 0, 1.70383925712239993810214054705e-1,
     1.07262030446373284651809199168e-1, -1.53194377486244017527936158236e-2,
     8.27378916381402288758473766002e-3},
    {6.24110958716075717114429577812e-1, 0, 0, -3.36089262944694129406857109825,
     -8.68219346841726006818189891453e-1, 2.75920996994467083049415600797e1,
     2.01540675504778934086186788979e1, -4.34898841810699588477366255144e1},
    {4.77662536438264365890433908527e-1, 0, 0, -2.48811461997166764192642586468,
     -5.90290826836842996371446475743e-1, 2.12300514481811942347288949897e1,
     1.52792336328824235832596922938e1, -3.32882109689848629194453265587e1,
     -2.03312017085086261358222928593e-2},
    {-9.3714243008598732571704021658e-1, 0, 0, 5.18637242884406370830023853209,
     1.09143734899672957818500254654, -8.14978701074692612513997267357, -1.85200656599969598641566180701e1,
     2.27394870993505042818970056734e1, 2.49360555267965238987089396762, -3.0467644718982195003823669022},
    {2.27331014751653820792359768449, 0, 0, -1.05344954667372501984066689879e1,
     -2.00087205822486249909675718444, -1.79589318631187989172765950534e1, 2.79488845294199600508499808837e1,
     -2.85899827713502369474065508674, -8.87285693353062954433549289258, 1.23605671757943030647266201528e1,
     6.43392746015763530355970484046e-1}};
constexpr double B[stages] = {5.42937341165687622380535766363e-2,
                              0,
                              0,
                              0,
                              0,
                              4.45031289275240888144113950566,
                              1.89151789931450038304281599044,
                              -5.8012039600105847814672114227,
                              3.1116436695781989440891606237e-1,
                              -1.52160949662516078556178806805e-1,
                              2.01365400804030348374776537501e-1,
                              4.47106157277725905176885569043e-2};
/// The errors of the embedded formulas of order 5 and 3.
constexpr double E5[stages] = {0.1312004499419488073250102996e-1,
                               0,
                               0,
                               0,
                               0,
                               -0.1225156446376204440720569753e1,
                               -0.4957589496572501915214079952,
                               0.1664377182454986536961530415e1,
                               -0.3503288487499736816886487290,
                               0.3341791187130174790297318841,
                               0.8192320648511571246570742613e-1,
                               -0.2235530786388629525884427845e-1};
constexpr double E3[stages] = {B[0] - 0.244094488188976377952755905512,
                               0,
                               0,
                               0,
                               0,
                               B[5],
                               B[6],
                               B[7],
                               B[8] - 0.733846688281611857341361741547,
                               B[9],
                               B[10],
                               B[11] - 0.220588235294117647058823529412e-1};

namespace detail {

// Rows of weights as types: Clang 14 takes no element of an array as a template argument.
template <std::size_t S>
struct StageRow {
  static constexpr double at(std::size_t j) { return A[S][j]; }
};
struct ResultRow {
  static constexpr double at(std::size_t j) { return B[j]; }
};
struct Error5Row {
  static constexpr double at(std::size_t j) { return E5[j]; }
};
struct Error3Row {
  static constexpr double at(std::size_t j) { return E3[j]; }
};

template <typename Row, std::size_t J, typename State>
void add(const State* k, State& sum) {
  constexpr double weight = Row::at(J);
  if constexpr (weight != 0)
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += weight * k[J][i];
}

template <typename Row, typename State, std::size_t... J>
State combine(const State* k, std::index_sequence<J...>) {
  State sum{};
  (add<Row, J>(k, sum), ...);
  return sum;
}

template <typename State>
State moved(const State& x, double h, const State& by) {
  State out;
  for (std::size_t i = 0; i < x.size(); ++i) out[i] = x[i] + h * by[i];
  return out;
}

template <typename State, typename Slope, std::size_t... S>
void fill(const State& x, double h, State* k, Slope&& f, std::index_sequence<S...>) {
  ((k[S + 1] = f(moved(x, h, combine<StageRow<S + 1>>(k, std::make_index_sequence<S + 1>())))), ...);
}

}  // namespace detail

/// The end of the step of length h from x, where `slope` is f(x). Evaluates f eleven times.
template <typename State, typename Slope>
State step(const State& x, const State& slope, double h, Slope&& f, State* error5 = nullptr,
           State* error3 = nullptr) {
  State k[stages];
  k[0] = slope;
  detail::fill(x, h, k, f, std::make_index_sequence<stages - 1>());
  constexpr auto all = std::make_index_sequence<stages>();
  if (error5) *error5 = detail::combine<detail::Error5Row>(k, all);
  if (error3) *error3 = detail::combine<detail::Error3Row>(k, all);
  return detail::moved(x, h, detail::combine<detail::ResultRow>(k, all));
}

/// The same for steps so short that order 4 is exact: evaluates f three times.
template <typename State, typename Slope>
State short_step(const State& x, const State& slope, double h, Slope&& f) {
  const State k2 = f(detail::moved(x, h / 2, slope)), k3 = f(detail::moved(x, h / 2, k2));
  const State k4 = f(detail::moved(x, h, k3));
  State out;
  for (std::size_t i = 0; i < x.size(); ++i) out[i] = x[i] + h / 6 * (slope[i] + 2 * (k2[i] + k3[i]) + k4[i]);
  return out;
}

/// For corrections so short that their square does not count.
template <typename State>
State tiny_step(const State& x, const State& slope, double h) {
  return detail::moved(x, h, slope);
}

}  // namespace afptraj::dop853
