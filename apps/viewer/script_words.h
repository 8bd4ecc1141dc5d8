#pragma once
/// The words of a line of a script, and what they must be.

#include <cstddef>
#include <string>
#include <vector>

namespace mq::view {

/// Words between spaces; "in quotes" is one; nothing after #. Throws `InvalidInput` where a quotation mark
/// is missing.
std::vector<std::string> words_of(const std::string& line);

/// Throws `InvalidInput` where the first word is no command, or too few or too many follow it.
void check_command(const std::vector<std::string>& words);

// Each throws `InvalidInput` with what was found and what was wanted.

double number(const std::string& word, double least, double most);
int whole(const std::string& word, int least, int most);
std::vector<double> numbers(const std::string& word, std::size_t count, const char* wanted);
/// Which of them it is.
int one_of(const std::string& word, const std::vector<std::string>& choices);
bool is_on(const std::string& word);

}  // namespace mq::view
