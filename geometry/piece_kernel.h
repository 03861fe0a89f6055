#pragma once

/// The innermost loop: one polynomial piece of a surface at one point. Internal to this room; see surface.h.
namespace afptraj {

/// Homogeneous values (w x, w y, w z, w) of a piece and its derivatives in its own parameters.
struct PieceValues {
  alignas(32) double f[4], fu[4], fv[4], fuu[4], fuv[4], fvv[4];
};

/// Horner over the (p + 1)(q + 1) coefficients `c` of x^i y^j, four numbers each, j fastest; 16-byte aligned.
/// Every machine gives the same bits: instruction sets differ in width only, none fuses.
void evaluate_piece(const double* c, int p, int q, double x, double y, PieceValues& out);
/// The value alone; the same bits as PieceValues::f.
void evaluate_piece_point(const double* c, int p, int q, double x, double y, double out[4]);

}  // namespace afptraj
