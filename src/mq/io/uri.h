#pragma once
/// The two ways in which a glTF file says bytes that are not its own: names and data URIs.

#include <optional>
#include <string>
#include <string_view>

#include "mq/io/bytes.h"

namespace mq {

/// The bytes of "data:[type];base64,..."; nothing when it is none, or its base64 is wrong.
std::optional<Bytes> data_of_uri(std::string_view uri);

/// "data:TYPE;base64,..." of bytes.
std::string data_uri(const std::string& type, ByteView bytes);

/// A file name with %XX decoded, '/' between folders.
std::string name_of_uri(std::string_view uri);

/// A file name with what a URI may not hold as %XX.
std::string uri_of_name(const std::string& name);

}  // namespace mq
