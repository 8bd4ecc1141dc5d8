// A stream: how many numbers (LEB128); unless none, a byte for the method, how many bytes (LEB128), and these. After
// the streams come how many bytes of bits (LEB128), and these, the lowest bit of a byte first.

#include "mq/io/detail/symbol_streams.h"

#include <draco/compression/entropy/symbol_decoding.h>
#include <draco/compression/entropy/symbol_encoding.h>
#include <fmt/format.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <bit>
#include <span>

#include "mq/base/error.h"

namespace mq {
namespace {

enum StreamMethod : int { one_token = 0, rans_tokens = 1, zstd_tokens = 2, deflate_tokens = 3 };  // 2 is only read

constexpr std::uint32_t most_token = 16 + 2 * 59 + 1;  // of 64 bits
constexpr int deflate_window = -15;  // 32 kB, without a head
constexpr int deflate_memory = 9;    // of 9

void put_leb(Bytes& bytes, std::uint64_t value) {
  for (; value >= 128; value >>= 7) bytes.push_back(std::byte(value | 128));
  bytes.push_back(std::byte(value));
}

Bytes by_rans(const std::vector<std::uint32_t>& tokens) {
  draco::EncoderBuffer buffer;
  if (!draco::EncodeSymbols(tokens.data(), int(tokens.size()), 1, nullptr, &buffer)) return {};
  const ByteView all = std::as_bytes(std::span(buffer.data(), buffer.size()));
  return {all.begin(), all.end()};
}

Bytes plain_bytes(const std::vector<std::uint32_t>& tokens) {
  Bytes plain;
  for (const std::uint32_t token : tokens) plain.push_back(std::byte(token));
  return plain;
}

Bytef* zlib_bytes(Bytes& bytes) { return reinterpret_cast<Bytef*>(bytes.data()); }
const Bytef* zlib_bytes(ByteView bytes) { return reinterpret_cast<const Bytef*>(bytes.data()); }

Bytes by_deflate(const std::vector<std::uint32_t>& tokens) {
  const Bytes plain = plain_bytes(tokens);
  z_stream to{};
  if (deflateInit2(&to, Z_BEST_COMPRESSION, Z_DEFLATED, deflate_window, deflate_memory, Z_DEFAULT_STRATEGY) != Z_OK)
    throw IoError("zlib: deflateInit2 failed");
  Bytes packed(deflateBound(&to, uLong(plain.size())));
  to.next_in = const_cast<Bytef*>(zlib_bytes(ByteView(plain)));
  to.avail_in = uInt(plain.size());
  to.next_out = zlib_bytes(packed);
  to.avail_out = uInt(packed.size());
  const int status = deflate(&to, Z_FINISH);
  packed.resize(to.total_out);
  deflateEnd(&to);
  if (status != Z_STREAM_END) throw IoError(fmt::format("zlib: deflate ended with status {}", status));
  return packed;
}

/// Whether the bytes are exactly as many as `plain` has.
bool inflated(ByteView packed, Bytes& plain) {
  z_stream from{};
  if (inflateInit2(&from, deflate_window) != Z_OK) return false;
  from.next_in = const_cast<Bytef*>(zlib_bytes(packed));
  from.avail_in = uInt(packed.size());
  from.next_out = zlib_bytes(plain);
  from.avail_out = uInt(plain.size());
  const int status = inflate(&from, Z_FINISH);
  const bool is_all = from.avail_in == 0 && from.avail_out == 0;
  inflateEnd(&from);
  return status == Z_STREAM_END && is_all;
}

void put_stream(Bytes& bytes, const std::vector<std::uint32_t>& tokens) {
  put_leb(bytes, tokens.size());
  if (tokens.empty()) return;
  Bytes payload = {std::byte(tokens.front())};
  StreamMethod method = one_token;
  if (std::ranges::adjacent_find(tokens, std::ranges::not_equal_to()) != tokens.end()) {
    payload = by_rans(tokens);
    method = rans_tokens;
    if (Bytes other = by_deflate(tokens); payload.empty() || other.size() < payload.size()) {
      payload = std::move(other);
      method = deflate_tokens;
    }
  }
  bytes.push_back(std::byte(method));
  put_leb(bytes, payload.size());
  bytes.insert(bytes.end(), payload.begin(), payload.end());
}

}  // namespace

void SymbolWriter::put(int stream, std::uint64_t value) {
  if (value < 16) {
    tokens_[std::size_t(stream)].push_back(std::uint32_t(value));
    return;
  }
  const int low = std::bit_width(value) - 2;
  tokens_[std::size_t(stream)].push_back(16 + 2 * std::uint32_t(low - 3) + (value >> low & 1));
  for (int bit = 0; bit < low; ++bit) {
    if (free_bits_ == 0) {
      bits_.push_back(std::byte(0));
      free_bits_ = 8;
    }
    bits_.back() |= std::byte((value >> bit & 1) << (8 - free_bits_--));
  }
}

Bytes SymbolWriter::bytes() const {
  Bytes bytes;
  for (const std::vector<std::uint32_t>& tokens : tokens_) put_stream(bytes, tokens);
  put_leb(bytes, bits_.size());
  bytes.insert(bytes.end(), bits_.begin(), bits_.end());
  return bytes;
}

SymbolReader::SymbolReader(ByteView bytes, int streams, std::size_t most, std::string what)
    : streams_(std::size_t(streams)), what_(std::move(what)) {
  std::size_t at = 0;
  const auto part = [&](std::uint64_t size) {
    if (size > bytes.size() - at) fail("ends too early");
    at += std::size_t(size);
    return bytes.subspan(at - std::size_t(size), std::size_t(size));
  };
  for (Stream& stream : streams_) {
    const std::uint64_t count = leb(bytes, at);
    if (count > most) fail("holds more numbers than it can");
    if (count == 0) continue;
    most -= std::size_t(count);
    const int method = std::to_integer<int>(part(1)[0]);
    const ByteView payload = part(leb(bytes, at));
    stream.tokens.resize(std::size_t(count));
    decode(payload, method, stream);
  }
  const ByteView bits = part(leb(bytes, at));
  bits_.assign(bits.begin(), bits.end());
  if (std::ranges::any_of(bytes.subspan(at), [](std::byte byte) { return byte != std::byte(0); }))
    fail("goes on after its end");
}

std::uint64_t SymbolReader::leb(ByteView bytes, std::size_t& at) const {
  std::uint64_t value = 0;
  for (int shift = 0; shift < 64; shift += 7) {
    if (at == bytes.size()) fail("ends too early");
    const auto byte = std::to_integer<std::uint64_t>(bytes[at++]);
    value |= (byte & 127) << shift;
    if (byte < 128) return value;
  }
  fail("holds a number of more than 64 bits");
}

void SymbolReader::decode(ByteView payload, int method, Stream& stream) const {
  std::vector<std::uint32_t>& tokens = stream.tokens;
  if (method == one_token) {
    if (payload.size() != 1) fail("repeats no token");
    std::ranges::fill(tokens, std::to_integer<std::uint32_t>(payload[0]));
  } else if (method == rans_tokens) {
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(payload.data()), payload.size());
    buffer.set_bitstream_version(draco::kDracoMeshBitstreamVersion);
    if (!draco::DecodeSymbols(std::uint32_t(tokens.size()), 1, &buffer, tokens.data()))
      fail("holds a stream that Draco cannot decode");
  } else if (method == zstd_tokens || method == deflate_tokens) {
    Bytes plain(tokens.size());
    if (method == deflate_tokens) {
      if (!inflated(payload, plain)) fail("holds a stream that zlib cannot decode");
    } else if (const std::size_t size = ZSTD_decompress(plain.data(), plain.size(), payload.data(), payload.size());
               ZSTD_isError(size) || size != plain.size()) {
      fail("holds a stream that zstd cannot decode");
    }
    std::ranges::transform(plain, tokens.begin(), [](std::byte b) { return std::to_integer<std::uint32_t>(b); });
  } else {
    fail(fmt::format("holds a stream of method {}, which is not known", method));
  }
  if (std::ranges::any_of(tokens, [](std::uint32_t token) { return token > most_token; }))
    fail("holds a token that says nothing");
}

std::uint64_t SymbolReader::long_number(std::uint32_t token) {
  const int low = int(token - 16) / 2 + 3;
  if (bit_ + std::size_t(low) > 8 * bits_.size()) fail("ends too early");
  std::uint64_t value = 0;
  for (int got = 0; got < low;) {
    const int within = int(bit_ % 8), take = std::min(8 - within, low - got);
    const std::uint64_t byte = std::to_integer<std::uint64_t>(bits_[bit_ / 8]) >> within;
    value |= (byte & ((1U << take) - 1)) << got;
    got += take;
    bit_ += std::size_t(take);
  }
  return value | std::uint64_t(2 + (token & 1)) << low;
}

std::size_t SymbolReader::index(int stream, std::size_t end) {
  const std::uint64_t value = get(stream);
  if (value >= end) fail(fmt::format("holds an index of {} where there are {}", value, end));
  return std::size_t(value);
}

void SymbolReader::end() const {
  for (const Stream& stream : streams_)
    if (stream.at != stream.tokens.size()) fail("holds numbers that nothing needs");
}

void SymbolReader::fail(const std::string& found) const {
  throw IoError(fmt::format("{} {}; use frames that do not need it, or make it again", what_, found));
}

}  // namespace mq
