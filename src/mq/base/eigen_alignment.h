#pragma once
/// Eigen chooses by the compiler's flags how it aligns its types and where it keeps the address that
/// it frees: 16 bytes for plain x86-64, 32 with -mavx, 64 with -mavx512f; a matrix made by one source
/// and freed by another would be "freed twice". So that the library and its callers agree whatever
/// flags each is compiled with, all of them define
///
///     EIGEN_MAX_ALIGN_BYTES=64          memory of matrices whose size is found at run time
///     EIGEN_MAX_STATIC_ALIGN_BYTES=16   members of structs and arrays of fixed size
///     EIGEN_MALLOC_ALREADY_ALIGNED=0    Eigen aligns memory itself and never frees it otherwise

#include <Eigen/Core>

static_assert(EIGEN_MAX_ALIGN_BYTES == 64 && EIGEN_DEFAULT_ALIGN_BYTES == 64 &&
                  EIGEN_MAX_STATIC_ALIGN_BYTES == 16 && EIGEN_MALLOC_ALREADY_ALIGNED == 0,
              "This source aligns Eigen's types in another way than Marquetry does: link the CMake target "
              "mq::mq or take the flags of 'pkg-config --cflags marquetry', which define "
              "EIGEN_MAX_ALIGN_BYTES=64, EIGEN_MAX_STATIC_ALIGN_BYTES=16 and EIGEN_MALLOC_ALREADY_ALIGNED=0");
