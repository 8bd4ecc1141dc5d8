// Prepared equations: set up once, solved for many signals.
#include <fmt/format.h>
#include <pybind11/stl.h>

#include <cmath>
#include <optional>

#include "calls.h"
#include "mq/base/error.h"
#include "mq/base/length.h"
#include "mq/filter/geodesic.h"
#include "mq/filter/screened_poisson.h"
#include "mq/linear/direct_solver.h"
#include "parts.h"
#include "spaces.h"

namespace mq::python {
namespace {

/// The equation and the space that it refers to.
class Poisson {
 public:
  Poisson(Space space, double weight, const py::object& screen, const std::string& how, double tolerance,
          int cycles, const py::object& progress)
      : space_(std::move(space)) {
    const SolverFactory factory = factory_of(*space_, {how, tolerance, cycles});
    std::vector<double> values;
    if (!screen.is_none()) values = numbers_from(screen, space_->size(), "screen");
    call(progress, [&](const Progress& inner) {
      equation_ = values.empty() ? std::make_unique<ScreenedPoisson>(*space_, weight, factory, inner)
                                 : std::make_unique<ScreenedPoisson>(*space_, weight, values, factory, inner);
    });
  }

  double weight() const { return equation_->weight(); }

  void set_weight(double weight, const py::object& progress) {
    call(progress, [&](const Progress& inner) { equation_->set_weight(weight, inner); });
  }

  py::tuple solve(const py::array& psi, const py::object& beta, const py::object& progress) {
    const SignalArray values = signal_from(psi, space_->size(), "psi");
    std::vector<double> factors;
    double factor = 0;
    if (PyNumber_Check(beta.ptr()) && !py::isinstance<py::array>(beta))
      factor = beta.cast<double>();
    else
      factors = numbers_from(py::array::ensure(beta), space_->size(), "beta");
    require(std::isfinite(factor), fmt::format("beta: found {}, wanted a finite number", factor));
    return solved(values.flat, progress, [&](const Progress& inner) {
      return factors.empty() ? equation_->solve(values.values, factor, inner)
                             : equation_->solve(values.values, factors, inner);
    });
  }

  py::tuple solve_towards(const py::array& psi, const py::array& moments, const py::object& progress) {
    const SignalArray values = signal_from(psi, space_->size(), "psi");
    const SignalArray wanted = signal_from(moments, space_->size(), "moments");
    require(wanted.values.cols() == values.values.cols(), "moments: wanted as many channels as psi has");
    return solved(values.flat, progress, [&](const Progress& inner) {
      return equation_->solve_towards(values.values, wanted.values, inner);
    });
  }

 private:
  template <class Solve>
  static py::tuple solved(bool flat, const py::object& progress, const Solve& solve) {
    Filtered found;
    call(progress, [&](const Progress& inner) { found = solve(inner); });
    return py::make_tuple(array_of(std::move(found.signal), flat), report_of(found.report));
  }

  Space space_;
  std::unique_ptr<ScreenedPoisson> equation_;
};

class Distances {
 public:
  Distances(Space space, double time, const std::string& how, double tolerance, int cycles,
            const py::object& progress)
      : space_(std::move(space)) {
    require(std::isfinite(time) && time > 0, fmt::format("time: found {}, wanted a number above 0", time));
    const SolverFactory factory = factory_of(*space_, {how, tolerance, cycles});
    call(progress, [&](const Progress& inner) {
      distances_ = std::make_unique<GeodesicDistance>(*space_, factory, GeodesicOptions{.time = time}, inner);
    });
  }

  py::tuple from(const py::array& unknowns, const py::object& given, const py::object& progress) {
    const std::vector<int> sources = indices_from(unknowns, space_->size(), "unknowns");
    std::vector<double> known(sources.size(), 0.0);
    if (!given.is_none()) known = numbers_from(given, std::ssize(sources), "distances");
    std::vector<GeodesicSource> places;
    for (std::size_t i = 0; i < sources.size(); ++i) {
      require(known[i] >= 0, "distances: found a value below 0");
      places.push_back({.unknown = sources[i], .distance = known[i]});
    }
    Geodesic found;
    call(progress, [&](const Progress& inner) { found = distances_->from(places, inner); });
    py::dict report = report_of(found.report);
    report["sweeps"] = found.sweeps;
    report["unreached"] = found.unreached;
    report["missed"] = found.change;
    std::vector<double> values(found.distance.begin(), found.distance.end());
    const auto count = py::ssize_t(values.size());
    return py::make_tuple(array_owning(std::move(values), {count}), report);
  }

 private:
  Space space_;
  std::unique_ptr<GeodesicDistance> distances_;
};

/// A·X = B for a matrix of a space, or any other that is symmetric and positive definite.
class Solver {
 public:
  Solver(const py::object& matrix, const std::optional<Space>& space, const std::string& how, double tolerance,
         int cycles, const py::object& progress)
      : space_(space.value_or(nullptr)) {
    const SparseMatrix A = matrix_from(matrix, "matrix");
    rows_ = A.rows();
    require(space_ == nullptr || space_->size() == rows_, "matrix: is not one of this space");
    require(space_ != nullptr || how != "multigrid",
            "solver: 'multigrid' is for matrices of a space: give the space as well");
    const SolverFactory factory = space_ ? factory_of(*space_, {how, tolerance, cycles}) : direct_solver();
    call(progress, [&](const Progress& inner) { solver_ = factory(A, inner); });
  }

  py::tuple solve(const py::array& B, const py::object& guess, const py::object& progress) {
    const SignalArray right = signal_from(B, rows_, "b");
    Signal X = Signal::Zero(right.values.rows(), right.values.cols());
    if (!guess.is_none()) {
      X = signal_from(guess, rows_, "guess").values;
      require(X.cols() == right.values.cols(), "guess: wanted as many channels as b has");
    }
    SolveReport report;
    call(progress, [&](const Progress& inner) { report = solver_->solve(right.values, X, inner); });
    return py::make_tuple(array_of(std::move(X), right.flat), report_of(report));
  }

 private:
  Space space_;
  Eigen::Index rows_ = 0;
  std::unique_ptr<LinearSolver> solver_;
};

}  // namespace

void add_equations(py::module_& module) {
  py::class_<Poisson>(module, "ScreenedPoisson")
      .def(py::init<Space, double, py::object, std::string, double, int, py::object>())
      .def_property_readonly("weight", &Poisson::weight)
      .def("set_weight", &Poisson::set_weight)
      .def("solve", &Poisson::solve)
      .def("solve_towards", &Poisson::solve_towards);
  py::class_<Distances>(module, "GeodesicDistance")
      .def(py::init<Space, double, std::string, double, int, py::object>())
      .def("from_", &Distances::from);
  py::class_<Solver>(module, "Solver")
      .def(py::init<py::object, std::optional<Space>, std::string, double, int, py::object>())
      .def("solve", &Solver::solve);
}

}  // namespace mq::python
