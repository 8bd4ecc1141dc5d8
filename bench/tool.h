#pragma once
/// What programs that scripts call have in common.

#include <exception>
#include <iostream>

namespace mq {

/// `work` with the command's words; where it throws the message goes to standard error, and the exit status is 2.
inline int run_tool(int (*work)(int count, char** words), int count, char** words) {
  try {
    return work(count, words);
  } catch (const std::exception& error) {
    std::cerr << error.what() << "\n";
    return 2;
  }
}

}  // namespace mq
