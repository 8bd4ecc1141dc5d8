#pragma once
/// --memory: large blocks of memory in a file, so that a program needs no more than it is given.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "mq/base/options.h"
#include "mq/model/messages.h"

namespace mq::app {

/// Adds --memory and --scratch.
void add_scratch_options(OptionTable& table);

/// Bytes by words: 8GB, 500MB, 7.5GiB, 50% of what the machine has; none for other words, and less than 100MB.
std::optional<std::int64_t> parse_memory(const std::string& words);

/// Where the words of a command ask for --memory, replaces this process by one that has its large blocks in a file
/// (apps/scratch) and is called with the same words; returns where they do not, or in that process. To be called
/// before anything is read or started. Throws `InvalidInput` where no such file can be had.
void start_with_scratch(const std::vector<std::string>& words);

/// Where --memory is so little that the program would hardly get on.
void warn_of_little_memory(const OptionValues& options, Messages& messages);

/// What is said where memory ran out, or the disk that stands for it.
std::string out_of_memory();

}  // namespace mq::app
