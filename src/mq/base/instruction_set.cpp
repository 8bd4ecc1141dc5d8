#include "mq/base/instruction_set.h"

#include <atomic>

#include <fmt/format.h>

#include "mq/base/error.h"

namespace mq {
namespace {

bool machine_has(InstructionSet set) {
  switch (set) {
#ifdef __clang__
    // Older Clang does not know the levels by name; these are what tells them apart.
    case InstructionSet::x86_64_v4:
      return machine_has(InstructionSet::x86_64_v3) && __builtin_cpu_supports("avx512f") &&
             __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512cd") &&
             __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
    case InstructionSet::x86_64_v3:
      return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
             __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2");
#else
    case InstructionSet::x86_64_v4: return __builtin_cpu_supports("x86-64-v4");
    case InstructionSet::x86_64_v3: return __builtin_cpu_supports("x86-64-v3");
#endif
    default: return true;
  }
}

std::atomic<InstructionSet>& in_use() {
  static std::atomic<InstructionSet> set = instruction_sets().back();
  return set;
}

}  // namespace

std::vector<InstructionSet> instruction_sets() {
  std::vector<InstructionSet> sets;
  for (const InstructionSet set :
       {InstructionSet::x86_64, InstructionSet::x86_64_v3, InstructionSet::x86_64_v4})
    if (machine_has(set)) sets.push_back(set);
  return sets;
}

InstructionSet instruction_set() { return in_use().load(std::memory_order_relaxed); }

void use_instruction_set(InstructionSet set) {
  if (!machine_has(set))
    throw Unsupported(fmt::format("this machine has no {} instructions: the best it has are {}",
                                  instruction_set_name(set),
                                  instruction_set_name(instruction_sets().back())));
  in_use() = set;
}

std::string instruction_set_name(InstructionSet set) {
  switch (set) {
    case InstructionSet::x86_64_v4: return "x86-64-v4";
    case InstructionSet::x86_64_v3: return "x86-64-v3";
    default: return "x86-64";
  }
}

InstructionSet parse_instruction_set(const std::string& name) {
  for (const InstructionSet set :
       {InstructionSet::x86_64, InstructionSet::x86_64_v3, InstructionSet::x86_64_v4})
    if (instruction_set_name(set) == name) return set;
  throw InvalidInput(fmt::format(
      "'{}' is no instruction set: write x86-64, x86-64-v3 or x86-64-v4", name));
}

}  // namespace mq
