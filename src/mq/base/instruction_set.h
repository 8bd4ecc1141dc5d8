#pragma once
/// The hottest loops, kernels, are compiled several times: for any x86-64 processor and for those with
/// wider registers and fused multiplication and addition. A program uses the best form that the
/// machine has; so one binary runs on all of them.
///
/// **Which bits depend on it.** A kernel's arithmetic is the same, operation by operation, in every
/// form, and sums are taken in the same order whatever the width of a register; but x86_64_v3 and
/// x86_64_v4 round a·b + c once, x86_64 twice. So v3 and v4 give equal bits, x86_64 others (they differ
/// in the last digits of single precision, and a solver's tolerance covers them). Within a form results
/// are equal to the last bit for any number of threads.

#include <string>
#include <vector>

namespace mq {

/// By the names of the psABI, which compilers take as -march=x86-64, x86-64-v3 and x86-64-v4.
enum class InstructionSet {
  x86_64,     ///< SSE2: every processor
  x86_64_v3,  ///< AVX2 and FMA: Haswell (2013), Excavator, Zen and later
  x86_64_v4   ///< AVX-512 F, BW, CD, DQ, VL: Skylake-X (2017), Zen 4 and later
};

/// What this machine has, in increasing order.
std::vector<InstructionSet> instruction_sets();

/// The one whose kernels are used: the best of this machine unless another was asked for.
InstructionSet instruction_set();

/// Uses another form from now on, for comparisons; not while anything is computed. Throws
/// `Unsupported` where the machine does not have it.
void use_instruction_set(InstructionSet set);

/// "x86-64-v3". `parse_instruction_set` throws `InvalidInput` on any other word.
std::string instruction_set_name(InstructionSet set);
InstructionSet parse_instruction_set(const std::string& name);

/// The table of kernels of the form in use.
template <class Kernels>
const Kernels& kernels_in_use(const Kernels& x86_64, const Kernels& v3, const Kernels& v4) {
  switch (instruction_set()) {
    case InstructionSet::x86_64_v4: return v4;
    case InstructionSet::x86_64_v3: return v3;
    default: return x86_64;
  }
}

}  // namespace mq
