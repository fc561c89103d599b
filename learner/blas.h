// Is the matrix library that libtorch calls a fast one?
#pragma once

namespace ohb::learner {

/// Billions of multiplications and additions a second of processor time, from a product of 512 x 512 (some
/// 20 ms). Makes no more of several processors than of one.
double matrix_product_gflops();

/// Warns (spdlog) if the product above is slower than 10: Debian's reference BLAS does 2.5, OpenBLAS 140.
void warn_of_slow_blas();

}  // namespace ohb::learner
