#pragma once
/// How a table of kernels is declared and where its forms are.
///
/// A source in a folder `kernels` is compiled once for each instruction set, with MARQUETRY_FORM the
/// namespace of that form (src/mq/CMakeLists.txt). The linker keeps one copy of an inline function,
/// whichever source it comes from, and one with AVX instructions would end a program on a machine
/// without them. Hence the rules of such a source, which a test reads off the objects: everything it
/// defines is in `mq::MARQUETRY_FORM` or in a namespace without a name; it gets and gives pointers
/// and plain structs; and it calls nothing inline from elsewhere: no containers, no Eigen, no std::min.

/// Declares `name()`, the table of the form in use, and the tables that the sources define. At namespace
/// mq, in a header that also includes mq/base/instruction_set.h.
#define MARQUETRY_KERNELS(Table, name)                                                \
  namespace x86_64 {                                                                  \
  extern const Table name;                                                            \
  }                                                                                   \
  namespace x86_64_v3 {                                                               \
  extern const Table name;                                                            \
  }                                                                                   \
  namespace x86_64_v4 {                                                               \
  extern const Table name;                                                            \
  }                                                                                   \
  inline const Table& name() { return kernels_in_use(x86_64::name, x86_64_v3::name, x86_64_v4::name); }
