#pragma once
/// What programs that scripts call have in common.

#include <exception>
#include <iostream>
#include <string_view>

namespace mq {

/// `work` with the command's words; where it throws the message goes to standard error, and the exit status is 2.
/// Without any word it is to throw how it is used, which goes to standard output where --help or -h asks.
inline int run_tool(int (*work)(int count, char** words), int count, char** words) {
  const bool asked = count == 2 && (std::string_view(words[1]) == "--help" || std::string_view(words[1]) == "-h");
  try {
    return work(asked ? 1 : count, words);
  } catch (const std::exception& error) {
    (asked ? std::cout : std::cerr) << error.what() << "\n";
    return asked ? 0 : 2;
  }
}

}  // namespace mq
