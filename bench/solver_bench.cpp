/// The solvers of texel systems, measured as the thesis measures its own (5.8.3 and 5.8.4).
///
///     solver_bench times bust_1 bust_4 bust bust_3000 --texels 800000      Table 5.1
///     solver_bench parts bust_1 bust_4 bust --texels 800000                Figure 5.9
///     solver_bench convergence bust cap scan.obj --texels 800000           Figures 5.10 to 5.12
///
/// Models are samples or files; --texels 0 takes files at their own size. Tables are Markdown;
/// --json FILE appends one object a line for each row, with the error after every cycle.
/// scripts/solver_bench runs all that docs/measurements/solver.md shows.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <limits>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>
#include <tbb/global_control.h>

#include "mq/base/error.h"
#include "mq/base/options.h"
#include "mq/baseline/reference_cycle.h"
#include "mq/fem/multigrid_solver.h"
#include "mq/fem/texel_hierarchy.h"
#include "mq/fem/texel_space.h"
#include "mq/linear/direct.h"
#include "mq/linear/residual.h"
#include "solver_cases.h"
#include "solver_parts.h"
#include "watch.h"

namespace mq {
namespace {

using namespace bench;

/// What is left after each cycle, 1 at the first guess, 0.
struct Curve {
  std::vector<double> errors = {1};     ///< RMS of X − exact over that of the exact solution
  std::vector<double> residuals = {1};  ///< ‖B − A·X‖ / ‖B‖

  int cycles() const { return int(errors.size()) - 1; }
};

class Measure {
 public:
  Measure(const System& system, Signal exact) : system_(system), exact_(std::move(exact)) {}
  void add(const Signal& X, Curve& curve) const {
    curve.errors.push_back((without_constants(system_, X) - exact_).norm() / exact_.norm());
    curve.residuals.push_back(residual(system_.A, X, system_.B).norm() / system_.B.norm());
  }

 private:
  const System& system_;
  Signal exact_;
};

struct Limits {
  double reached = 1e-6;
  int cycles = 40;
  static constexpr int least_cycles = 5;  // what the thesis compares models by

  bool go_on(const Curve& curve) const {
    return curve.cycles() < cycles && (curve.cycles() < least_cycles ||
                                       std::max(curve.errors.back(), curve.residuals.back()) > reached);
  }
};

Curve reference_curve(const Case& c, const System& system, const Measure& measure,
                      const Limits& limits) {
  const ReferenceCycle<double> cycle(system.A, c.space->texels(), {});
  ReferenceCycle<double>::Workspace workspace(cycle, 4, 3);
  Signal B = Signal::Zero(system.B.rows(), 4), X = B;
  B.leftCols(3) = system.B;
  Curve curve;
  while (limits.go_on(curve)) {
    cycle.cycle(B.data(), X.data(), workspace);
    measure.add(X.leftCols(3), curve);
  }
  return curve;
}

/// Ours says nothing before it ends: so it solves with 1, 2, ... cycles, each time from the start.
Curve our_curve(const Case& c, const System& system, const Measure& measure, const Limits& limits) {
  const Hierarchy h = texel_hierarchy(system.A, c.space->texels());
  Curve curve;
  while (limits.go_on(curve)) {
    Signal X = Signal::Zero(system.B.rows(), 3);
    mixed_conjugate_gradients(h.high(), h.low(), h.scaling(), h.multigrid(), h.components(),
                              system.B, X, {.tolerance = 1e-14, .max_cycles = curve.cycles() + 1});
    measure.add(X, curve);
  }
  return curve;
}

std::string short_number(double x) { return std::isinf(x) ? "∞" : fmt::format("{:g}", x); }

class Record {
 public:
  explicit Record(const std::string& path)
      : file_(path.empty() ? nullptr : std::fopen(path.c_str(), "a")) {
    require(path.empty() || file_, path + ": cannot be written");
  }
  ~Record() {
    if (file_) std::fclose(file_);
  }
  Record(const Record&) = delete;
  Record& operator=(const Record&) = delete;
  void line(const std::string& json) {
    if (!file_) return;
    fmt::print(file_, "{}\n", json);
    std::fflush(file_);
  }

 private:
  std::FILE* file_;
};

std::string json_list(const std::vector<double>& values) {
  std::string text;
  for (const double v : values) text += fmt::format("{}{:.4g}", text.empty() ? "" : ", ", v);
  return "[" + text + "]";
}

/// By what factor values fall per cycle, from the first to the first that is at most `reached`.
double mean_factor(const std::vector<double>& values, double reached) {
  std::size_t last = 1;
  while (last + 1 < values.size() && values[last] > reached) ++last;
  return std::pow(values.front() / values[last], 1.0 / double(last));
}

/// After how many cycles; "> 40" where there were not enough.
std::string cycles_to(const std::vector<double>& values, double reached) {
  for (std::size_t k = 0; k < values.size(); ++k)
    if (values[k] <= reached) return std::to_string(k);
  return fmt::format("> {}", values.size() - 1);
}

void print_curve(const Case& c, double alpha, const std::string& solver, const Curve& curve,
                 const Limits& limits, Record& record) {
  const auto after = [&](std::size_t cycle) {
    return cycle < curve.errors.size() ? fmt::format("{:.1e}", curve.errors[cycle])
                                       : std::string("–");
  };
  const Distortion most = distortion_of_most(c);
  const double factor = mean_factor(curve.errors, limits.reached),
               of_residual = mean_factor(curve.residuals, limits.reached);
  fmt::print("| {} | {} | {} | {:.1f} | {} | {} | {:.1f} | {} | {:.1f} | {} | {} | {} |\n", c.name,
             c.space->size(), c.atlas.charts.size(), most.stretch, short_number(alpha), solver, factor,
             cycles_to(curve.errors, limits.reached), of_residual, after(1), after(2), after(5));
  std::fflush(stdout);
  record.line(fmt::format(
      R"({{"model": "{}", "texels": {}, "charts": {}, "stretch": {:.3g}, "authalic": {:.3g}, "conformal": {:.3g}, "alpha": "{}", "solver": "{}", "factor": {:.4g}, "residual_factor": {:.4g}, "errors": {}, "residuals": {}}})",
      c.name, c.space->size(), c.atlas.charts.size(), most.stretch, most.authalic, most.conformal,
      std::isinf(alpha) ? "infinity" : fmt::format("{:g}", alpha), solver, factor, of_residual,
      json_list(curve.errors), json_list(curve.residuals)));
}

struct Request {
  std::vector<double> alphas;
  std::vector<std::string> solvers;
  std::int64_t most_for_direct = 0;
  std::int64_t most_for_reference = 0;
  bool wall = false;
  Limits limits;
  bool wants(const std::string& solver) const {
    return std::find(solvers.begin(), solvers.end(), solver) != solvers.end();
  }
};

void measure_convergence(const Case& c, const Request& request, Record& record) {
  const bool factored = c.space->size() <= request.most_for_direct;
  std::unique_ptr<DirectSolver> direct;
  for (const double alpha : request.alphas) {
    const System system = make_system(*c.space, alpha);
    const Measure measure(system,
                          factored ? direct_solution(system, direct) : our_solution(c, system));
    if (request.wants("reference") && c.space->size() <= request.most_for_reference)
      print_curve(c, alpha, "reference", reference_curve(c, system, measure, request.limits),
                  request.limits, record);
    if (request.wants("ours"))
      print_curve(c, alpha, factored ? "ours" : "ours, against itself",
                  our_curve(c, system, measure, request.limits), request.limits, record);
  }
}

/// Thesis 5.8.3: initialise is what depends on the pattern alone, update what depends on the
/// values, solve a substitution, or one cycle; three channels.
struct Times {
  double initialise = 0, update = 0, solve = 0;
  double all = 0;  ///< first setup and solution to a relative residual of 1e-6
  int cycles = 0;
};

Times direct_times(const System& system, bool wall) {
  Times times;
  const SparseMatrix A = definite(system);
  std::unique_ptr<DirectSolver> direct;
  const double both = seconds_of(wall, [&] { direct = std::make_unique<DirectSolver>(A); });
  times.update = seconds_of(wall, [&] { direct->refactor(A); });
  times.initialise = both - times.update;
  Signal X;
  times.solve = seconds_of(wall, [&] { X = direct->solve(system.B); });
  times.all = both + times.solve;
  times.cycles = 1;
  return times;
}

Times iterative_times(const SolverFactory& factory, const System& system, bool wall) {
  Times times;
  std::unique_ptr<LinearSolver> solver;
  const double both = seconds_of(wall, [&] { solver = factory(system.A, {}); });
  times.update = seconds_of(wall, [&] { solver->update(system.A, {}); });
  times.initialise = both - times.update;
  Signal X = Signal::Zero(system.B.rows(), system.B.cols());
  SolveReport report;
  const double solution = seconds_of(wall, [&] { report = solver->solve(system.B, X); });
  times.cycles = report.cycles;
  times.solve = solution / std::max(1, report.cycles);
  times.all = both + solution;
  return times;
}

/// One cycle without the residual that says when to stop.
double reference_cycle_seconds(const Case& c, const System& system, bool wall) {
  const ReferenceCycle<double> cycle(system.A, c.space->texels(), {});
  ReferenceCycle<double>::Workspace workspace(cycle, 4, 3);
  Signal B = Signal::Zero(system.B.rows(), 4), X = B;
  B.leftCols(3) = system.B;
  double best = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 5; ++i)
    best = std::min(best, seconds_of(wall, [&] { cycle.cycle(B.data(), X.data(), workspace); }));
  return best;
}

void print_times(const Case& c, const std::string& solver, const Times& t, Record& record) {
  fmt::print("| {} | {} | {} | {} | {:.2f} : {:.2f} : {:.3f} | {} | {:.2f} |\n", c.name,
             c.space->size(), c.atlas.charts.size(), solver, t.initialise, t.update, t.solve,
             t.cycles, t.all);
  std::fflush(stdout);
  record.line(fmt::format(
      R"({{"model": "{}", "texels": {}, "charts": {}, "solver": "{}", "initialise": {:.4g}, "update": {:.4g}, "solve": {:.4g}, "cycles": {}, "all": {:.4g}}})",
      c.name, c.space->size(), c.atlas.charts.size(), solver, t.initialise, t.update, t.solve,
      t.cycles, t.all));
}

/// What comes before any solver: cells and seams, and the matrix.
void print_assembly(const Case& c, const Request& request, Record& record) {
  std::unique_ptr<TexelSpace> space;
  const double cells =
      seconds_of(request.wall, [&] { space = std::make_unique<TexelSpace>(c.surface, c.atlas); });
  SparseMatrix A;
  const double matrix = seconds_of(request.wall, [&] {
    A = space->regularised_system(1, request.alphas.front() * space->scale().area);
  });
  fmt::print("| {} | {} | {} | assembly | cells {:.2f}, matrix {:.2f} | | {:.2f} |\n", c.name,
             c.space->size(), c.atlas.charts.size(), cells, matrix, cells + matrix);
  record.line(fmt::format(
      R"({{"model": "{}", "texels": {}, "charts": {}, "cells": {:.4g}, "matrix": {:.4g}}})", c.name,
      c.space->size(), c.atlas.charts.size(), cells, matrix));
}

void measure_times(const Case& c, const Request& request, Record& record) {
  print_assembly(c, request, record);
  const System system = make_system(*c.space, request.alphas.front());
  const Texels& texels = c.space->texels();
  if (request.wants("direct") && c.space->size() <= request.most_for_direct) {
    const std::string name =
        factorisations().front() == Factorisation::cholmod ? "CHOLMOD" : "Eigen";
    print_times(c, name, direct_times(system, request.wall), record);
  }
  if (request.wants("reference") && c.space->size() <= request.most_for_reference) {
    Times times = iterative_times(reference_solver(texels), system, request.wall);
    times.solve = reference_cycle_seconds(c, system, request.wall);
    print_times(c, "reference", times, record);
  }
  if (request.wants("ours"))
    print_times(c, "ours", iterative_times(multigrid_solver(texels), system, request.wall), record);
}

// ---- Parts of a cycle ----

void print_parts(const Case& c, const std::string& solver, const CycleParts& p, Record& record) {
  const auto ms = [](double seconds) { return fmt::format("{:.1f}", 1e3 * seconds); };
  fmt::print("| {} | {} | {} | {} | {} | {} | {} | {} | {} | {} |\n", c.name, c.space->size(), c.atlas.charts.size(),
             solver, ms(p.stencils), ms(p.boundary), ms(p.transfers), ms(p.coarse), ms(p.sum()), ms(p.whole));
  std::fflush(stdout);
  record.line(fmt::format(
      R"({{"model": "{}", "texels": {}, "charts": {}, "solver": "{}", "stencils": {:.4g}, "boundary": {:.4g}, "transfers": {:.4g}, "coarse": {:.4g}, "whole": {:.4g}}})",
      c.name, c.space->size(), c.atlas.charts.size(), solver, p.stencils, p.boundary, p.transfers, p.coarse, p.whole));
}

void measure_parts(const Case& c, const Request& request, Record& record) {
  const System system = make_system(*c.space, request.alphas.front());
  if (request.wants("reference") && c.space->size() <= request.most_for_reference)
    print_parts(c, "reference", reference_parts(c, system, request.wall), record);
  if (request.wants("ours")) print_parts(c, "ours", our_parts(c, system, request.wall), record);
}

OptionTable options() {
  using Type = Option::Type;
  OptionTable table("solver_bench", "Measure the solvers of texel systems.");
  table.add({.name = "measure",
             .place = Option::Place::positional,
             .type = Type::choice,
             .required = true,
             .choices = {"times", "parts", "convergence"},
             .help = "what to measure"});
  table.add({.name = "model",
             .place = Option::Place::positional,
             .type = Type::text,
             .count = Option::Count::many,
             .required = true,
             .help = "samples and files of models"});
  table.add({.name = "texels",
             .type = Type::number,
             .default_value = "800000",
             .least = 0,
             .help = "about so many, by the size of the texture; 0: the texture's own"});
  table.add({.name = "alpha",
             .type = Type::text,
             .count = Option::Count::many,
             .help = "the thesis' weight, or inf; convergence: by default 1e-4, 1e-2 and inf, "
                     "times and parts: 1e-4"});
  table.add({.name = "solver",
             .type = Type::choice,
             .count = Option::Count::many,
             .choices = {"direct", "reference", "ours"},
             .help = "by default all"});
  table.add({.name = "most-for-direct",
             .type = Type::integer,
             .default_value = "4000000",
             .help = "texels up to which matrices are factored"});
  table.add({.name = "most-for-reference",
             .type = Type::integer,
             .default_value = "4000000",
             .help = "texels up to which the reference is measured"});
  table.add({.name = "error",
             .type = Type::number,
             .default_value = "1e-6",
             .help = "convergence: the relative error and residual to reach"});
  table.add({.name = "cycles",
             .type = Type::integer,
             .default_value = "40",
             .help = "convergence: ... or after so many cycles"});
  table.add({.name = "threads",
             .type = Type::integer,
             .default_value = "1",
             .least = 0,
             .help = "0: one per core"});
  table.add({.name = "wall", .help = "seconds of the clock on the wall, not of the processor"});
  table.add({.name = "json", .type = Type::path, .help = "append one object a line to this file"});
  return table;
}

Request request_of(const OptionValues& values) {
  const bool convergence = values.text("measure") == "convergence";
  Request request;
  for (const std::string& alpha : values.texts("alpha")) request.alphas.push_back(std::stod(alpha));
  if (request.alphas.empty())
    request.alphas = convergence
                         ? std::vector<double>{1e-4, 1e-2, std::numeric_limits<double>::infinity()}
                         : std::vector<double>{1e-4};
  request.solvers = values.texts("solver");
  if (request.solvers.empty()) request.solvers = {"direct", "reference", "ours"};
  request.most_for_direct = values.integer("most-for-direct");
  request.most_for_reference = values.integer("most-for-reference");
  request.wall = values.flag("wall");
  request.limits = {values.number("error"), int(values.integer("cycles"))};
  return request;
}

void print_head(const std::string& what) {
  if (what == "times")
    fmt::print(
        "| model | texels | charts | solver | initialise : update : solve | cycles to 1e-6 | "
        "all of that, s |\n|---|---|---|---|---|---|---|\n");
  else if (what == "parts")
    fmt::print(
        "| model | texels | charts | solver | interior | boundary | transfers | coarse | sum, ms | cycle, ms |\n"
        "|---|---|---|---|---|---|---|---|---|---|\n");
  else
    fmt::print(
        "| model | texels | charts | stretch | alpha | solver | factor | cycles | of residual | "
        "after 1 | after 2 | after 5 |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n");
}

void run(const std::vector<std::string>& words) {
  const OptionValues values = parse_arguments(options(), words);
  values.check();
  const int threads = int(values.integer("threads"));
  const tbb::global_control control(
      tbb::global_control::max_allowed_parallelism,
      threads > 0 ? threads : std::max(1u, std::thread::hardware_concurrency()));
  const Request request = request_of(values);
  Record record(values.has("json") ? values.text("json") : "");
  const std::string& what = values.text("measure");
  print_head(what);
  for (const std::string& model : values.texts("model")) {
    try {
      const std::unique_ptr<Case> c = make_case(model, values.number("texels"));
      if (what == "times")
        measure_times(*c, request, record);
      else if (what == "parts")
        measure_parts(*c, request, record);
      else
        measure_convergence(*c, request, record);
    } catch (const Error& e) {
      fmt::print(stderr, "{}: {}\n", model, e.what());
    }
  }
}

}  // namespace
}  // namespace mq

int main(int argc, char** argv) {
  try {
    const std::vector<std::string> words(argv + 1, argv + argc);
    if (words.empty() || words.front() == "--help" || words.front() == "-h") {
      fmt::print("{}", mq::help_text(mq::options(), mq::HelpDetail::complete));
      return 0;
    }
    mq::run(words);
  } catch (const std::exception& e) {
    fmt::print(stderr, "solver_bench: {}\n", e.what());
    return 2;
  }
}
