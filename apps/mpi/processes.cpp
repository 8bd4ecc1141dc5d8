#include "processes.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <new>

#include "mq/base/error.h"

namespace mq::shared {
namespace {

constexpr int tag = 7, error_status = 2;
constexpr std::size_t most_bytes = std::size_t(1) << 30;  ///< of one message, whose length MPI counts in an int

/// Where errors are said, also by processes that are silent.
int& stream_of_errors() {
  static int stream = STDERR_FILENO;
  return stream;
}

enum class Outcome : int { done, failed, cancelled };

struct Failure {
  Outcome outcome = Outcome::done;
  std::string message;
};

/// Runs the work and says what it threw.
Failure attempted(const Processes& processes, const std::function<void()>& work) {
  try {
    work();
    return {};
  } catch (const Cancelled&) {
    return {Outcome::cancelled, "cancelled"};
  } catch (const std::bad_alloc&) {
    return {Outcome::failed,
            fmt::format("process {} of {} has not enough memory: use more processes on more machines, or "
                        "smaller textures",
                        processes.rank(), processes.count())};
  } catch (const std::exception& error) {
    return {Outcome::failed, error.what()};
  }
}

}  // namespace

Processes::Processes() {
  MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
  MPI_Comm_size(MPI_COMM_WORLD, &count_);
}

void Processes::together(const std::function<void()>& work) const {
  Failure failure = attempted(*this, work);
  int first = failure.outcome == Outcome::done ? count_ : rank_;
  MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
  if (first == count_) return;
  int head[2] = {int(failure.outcome), int(failure.message.size())};
  MPI_Bcast(head, 2, MPI_INT, first, MPI_COMM_WORLD);
  failure.message.resize(std::size_t(head[1]));
  MPI_Bcast(failure.message.data(), head[1], MPI_CHAR, first, MPI_COMM_WORLD);
  if (Outcome(head[0]) == Outcome::cancelled) throw Cancelled();
  throw InvalidInput(failure.message);
}

void Processes::talking(const std::function<void()>& work) const {
  const Failure failure = attempted(*this, work);
  if (failure.outcome == Outcome::done) return;
  const std::string line = "marquetry-mpi: error: " + failure.message + "\n";
  [[maybe_unused]] const auto written = ::write(stream_of_errors(), line.data(), line.size());
  MPI_Abort(MPI_COMM_WORLD, error_status);
}

void Processes::in_turns(const std::function<void()>& work) const {
  Failure failure;
  for (int turn = 0; turn < count_; ++turn) {
    if (turn == rank_) failure = attempted(*this, work);
    MPI_Barrier(MPI_COMM_WORLD);
  }
  together([&] {
    if (failure.outcome == Outcome::cancelled) throw Cancelled();
    if (failure.outcome == Outcome::failed) throw InvalidInput(failure.message);
  });
}

void Processes::sum(std::span<double> values) const {
  MPI_Allreduce(MPI_IN_PLACE, values.data(), int(values.size()), MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
}

void Processes::largest(std::span<double> values) const {
  MPI_Allreduce(MPI_IN_PLACE, values.data(), int(values.size()), MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
}

double Processes::largest(double value) const {
  largest(std::span(&value, 1));
  return value;
}

std::vector<int> Processes::exchange_counts(const std::vector<std::span<const std::byte>>& parts,
                                            std::size_t size) const {
  std::vector<int> sent, received(parts.size());
  for (const auto& part : parts) sent.push_back(int(part.size() / size));
  MPI_Alltoall(sent.data(), 1, MPI_INT, received.data(), 1, MPI_INT, MPI_COMM_WORLD);
  return received;
}

void Processes::exchange_bytes(const std::vector<std::span<const std::byte>>& to,
                               const std::vector<std::span<std::byte>>& from) const {
  std::vector<MPI_Request> requests;
  const auto in_pieces = [](auto all, const auto& visit) {
    for (std::size_t at = 0; at < all.size(); at += most_bytes)
      visit(all.subspan(at, std::min(most_bytes, all.size() - at)));
  };
  for (int p = 0; p < count_; ++p)
    if (p != rank_)
      in_pieces(from[std::size_t(p)], [&](std::span<std::byte> piece) {
        MPI_Irecv(piece.data(), int(piece.size()), MPI_BYTE, p, tag, MPI_COMM_WORLD, &requests.emplace_back());
      });
  for (int p = 0; p < count_; ++p)
    if (p != rank_)
      in_pieces(to[std::size_t(p)], [&](std::span<const std::byte> piece) {
        MPI_Isend(piece.data(), int(piece.size()), MPI_BYTE, p, tag, MPI_COMM_WORLD, &requests.emplace_back());
      });
  std::ranges::copy(to[std::size_t(rank_)], from[std::size_t(rank_)].begin());
  MPI_Waitall(int(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
}

std::vector<std::string> Processes::gather(const std::string& text) const {
  const std::vector<char> own(text.begin(), text.end());
  std::vector<std::string> all;
  for (const auto& one : exchange(std::vector(std::size_t(count_), own))) all.emplace_back(one.begin(), one.end());
  return all;
}

std::vector<std::string> Processes::gather_lines(const std::vector<std::string>& lines) const {
  std::string own;
  for (const std::string& line : lines) own += line + '\n';
  std::vector<std::string> all;
  for (const std::string& of_one : gather(own))
    for (std::size_t at = 0, end; (end = of_one.find('\n', at)) != std::string::npos; at = end + 1)
      all.push_back(of_one.substr(at, end - at));
  return all;
}

void silence_others(const Processes& processes) {
  if (processes.is_first()) return;
  stream_of_errors() = ::dup(STDERR_FILENO);
  const int nowhere = ::open("/dev/null", O_WRONLY);
  ::dup2(nowhere, STDOUT_FILENO);
  ::dup2(nowhere, STDERR_FILENO);
  ::close(nowhere);
}

}  // namespace mq::shared
