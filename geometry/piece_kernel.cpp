#include "geometry/piece_kernel.h"

#include <cstring>

// One body, compiled for each width and chosen when the program is loaded.
#if defined(__x86_64__) && defined(__GLIBC__)
#define AFPTRAJ_WIDTHS __attribute__((target_clones("default", "avx2")))
#else
#define AFPTRAJ_WIDTHS
#endif
#define AFPTRAJ_INLINE [[gnu::always_inline]] inline

namespace afptraj {
namespace {

using Lanes [[gnu::vector_size(32)]] = double;

// References throughout: a Lanes passed by value has another ABI in each clone.
AFPTRAJ_INLINE void load(const double* c, Lanes& out) { std::memcpy(&out, c, sizeof out); }
AFPTRAJ_INLINE void store(const Lanes& value, double* out) { std::memcpy(out, &value, sizeof value); }

/// A row of Q + 1 coefficients at y: value, first derivative, half of the second.
template <int Q>
AFPTRAJ_INLINE void row(const double* c, double y, Lanes& f, Lanes& d, Lanes& dd) {
  const Lanes zero = {};
  load(c + 4 * Q, f);
  d = dd = zero;
  for (int j = Q - 1; j >= 0; --j) {
    Lanes a;
    load(c + 4 * j, a);
    if (j < Q - 1) dd = dd * y + d;
    d = d * y + f;
    f = f * y + a;
  }
}

template <int Q>
AFPTRAJ_INLINE void piece(const double* c, int p, double x, double y, PieceValues& out) {
  constexpr int stride = 4 * (Q + 1);
  const Lanes zero = {};
  Lanes f, fv, fvv, fu = zero, fuu = zero, fuv = zero;
  row<Q>(c + p * stride, y, f, fv, fvv);
  for (int i = p - 1; i >= 0; --i) {
    Lanes r, rv, rvv;
    row<Q>(c + i * stride, y, r, rv, rvv);
    fuu = fuu * x + fu;
    fu = fu * x + f;
    f = f * x + r;
    fuv = fuv * x + fv;
    fv = fv * x + rv;
    fvv = fvv * x + rvv;
  }
  store(f, out.f);
  store(fu, out.fu);
  store(fv, out.fv);
  store(fuu + fuu, out.fuu);
  store(fuv, out.fuv);
  store(fvv + fvv, out.fvv);
}

template <int Q>
AFPTRAJ_INLINE void piece_point(const double* c, int p, double x, double y, double* out) {
  constexpr int stride = 4 * (Q + 1);
  Lanes f = {};
  for (int i = p; i >= 0; --i) {
    Lanes r;
    load(c + i * stride + 4 * Q, r);
    for (int j = Q - 1; j >= 0; --j) {
      Lanes a;
      load(c + i * stride + 4 * j, a);
      r = r * y + a;
    }
    f = f * x + r;
  }
  store(f, out);
}

}  // namespace

AFPTRAJ_WIDTHS void evaluate_piece(const double* c, int p, int q, double x, double y, PieceValues& out) {
  switch (q) {
    case 1: return piece<1>(c, p, x, y, out);
    case 2: return piece<2>(c, p, x, y, out);
    case 3: return piece<3>(c, p, x, y, out);
    case 4: return piece<4>(c, p, x, y, out);
    case 5: return piece<5>(c, p, x, y, out);
    case 6: return piece<6>(c, p, x, y, out);
    case 7: return piece<7>(c, p, x, y, out);
    case 8: return piece<8>(c, p, x, y, out);
    default: return piece<9>(c, p, x, y, out);
  }
}

AFPTRAJ_WIDTHS void evaluate_piece_point(const double* c, int p, int q, double x, double y, double out[4]) {
  switch (q) {
    case 1: return piece_point<1>(c, p, x, y, out);
    case 2: return piece_point<2>(c, p, x, y, out);
    case 3: return piece_point<3>(c, p, x, y, out);
    case 4: return piece_point<4>(c, p, x, y, out);
    case 5: return piece_point<5>(c, p, x, y, out);
    case 6: return piece_point<6>(c, p, x, y, out);
    case 7: return piece_point<7>(c, p, x, y, out);
    case 8: return piece_point<8>(c, p, x, y, out);
    default: return piece_point<9>(c, p, x, y, out);
  }
}

}  // namespace afptraj
