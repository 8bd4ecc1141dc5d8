#pragma once
/// Included by kernels only (base/kernel_forms.h).

namespace mq::MARQUETRY_FORM {

/// A product that is rounded before anything is added to it. Where two products are added, a compiler
/// may fuse the one or the other, and chooses otherwise from form to form; so it is told which.
template <class Value>
inline Value rounded(Value product) {
#ifdef __FMA__
  asm("" : "+v"(product));
#endif
  return product;
}

}  // namespace mq::MARQUETRY_FORM
