#pragma once
/// What is under a name, where folders on the way to it may be closed to this user.
///
/// The standard library says so by an exception of its own, or in an error code that is easily taken for "not there".
/// Here it is an `IoError`: what the system says, and that another name is wanted.

#include <filesystem>

namespace mq {

/// Whether something of this name is there, be it a file, a folder or what a link leads to. Throws `IoError` where that
/// cannot be known: a folder on the way may not be searched, the name is too long, links lead in a circle.
bool is_there(const std::filesystem::path& path);

/// Whether a folder of this name is there. Throws as `is_there` does.
bool is_folder(const std::filesystem::path& path);

/// The same for all spellings of a file's name, whether it is there or not: absolute, links followed as far as there
/// are any. Where a folder on the way may not be searched its links are not followed. Never empty for a name that is
/// not, throws nothing of its own.
std::filesystem::path full_name(const std::filesystem::path& path);

}  // namespace mq
