#pragma once
/// What work on a model has to say to the person who waits for it, while it goes on.

#include <string>

namespace mq {

/// Given to what may take long or may find the user's data odd. This one hears nothing; a program
/// derives from it and shows what it is told. Calls come from the thread that called.
class Messages {
 public:
  virtual ~Messages() = default;

  /// Something worth knowing; the result is what was asked for.
  virtual void remark(const std::string& text);

  /// The result may not be what was wanted. The text names the remedy.
  virtual void warning(const std::string& text);

  /// What is safe from now on, should the work be stopped, in words: "out.evolving has 3 of 9
  /// frames". Takes the place of what was said before; empty: nothing is.
  virtual void safe(const std::string& text);
};

/// "FILE: NOTE", or the note as it is where it begins with the file already.
std::string note_on(const std::string& file, const std::string& note);

}  // namespace mq
