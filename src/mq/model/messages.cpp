#include "mq/model/messages.h"

namespace mq {

void Messages::remark(const std::string&) {}
void Messages::warning(const std::string&) {}
void Messages::safe(const std::string&) {}

std::string note_on(const std::string& file, const std::string& note) {
  return note.starts_with(file) ? note : file + ": " + note;
}

}  // namespace mq
