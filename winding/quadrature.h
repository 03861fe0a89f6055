#pragma once

#include <array>
#include <cmath>

namespace afptraj {

/// The integral of f over [a, b] by Gauss-Legendre's rule of eight points, exact to degree 15. f is not asked
/// at a and b.
template <typename F>
double gauss_legendre(const F& f, double a, double b) {
  constexpr std::array<double, 4> x{0.1834346424956498049394761, 0.5255324099163289858177390,
                                    0.7966664774136267395915539, 0.9602898564975362316835609};
  constexpr std::array<double, 4> w{0.3626837833783619829651504, 0.3137066458778872873379622,
                                    0.2223810344533744705443560, 0.1012285362903762591525314};
  const double middle = (a + b) / 2, half = (b - a) / 2;
  double sum = 0;
  for (std::size_t i = 0; i < x.size(); ++i)
    sum += w[i] * (f(middle - half * x[i]) + f(middle + half * x[i]));
  return sum * half;
}

/// The same, halved until both halves together agree with the whole to `tolerance`. f is smooth inside.
template <typename F>
double integral(const F& f, double a, double b, double tolerance, int depth = 0) {
  constexpr int deepest = 14;
  const double middle = (a + b) / 2;
  const double whole = gauss_legendre(f, a, b);
  const double halves = gauss_legendre(f, a, middle) + gauss_legendre(f, middle, b);
  if (std::abs(halves - whole) <= tolerance || depth >= deepest) return halves;
  return integral(f, a, middle, tolerance / 2, depth + 1) + integral(f, middle, b, tolerance / 2, depth + 1);
}

}  // namespace afptraj
