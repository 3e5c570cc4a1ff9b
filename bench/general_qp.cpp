#include "contact_ticks.hpp"

#ifdef STICTION_HAS_PROXQP
#include "proxqp.hpp"
#endif
#if __has_include(<interfaces/highs_c_api.h>) && defined(STICTION_HIGHS_LIBRARY)
#define STICTION_HAS_HIGHS 1
#include <dlfcn.h>
#include <interfaces/highs_c_api.h>
#endif

#include <chrono>

namespace stiction::bench {
namespace {

using Eigen::Index;
using Clock = std::chrono::steady_clock;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

[[maybe_unused]] constexpr double kResidual = 1e-6;

/// min ½ xᵀH x + gᵀx  s.t.  A x = b ,  lower ≤ x ≤ upper .
struct Program {
  Eigen::MatrixXd H;
  RowMajor A;
  Eigen::VectorXd g, b, lower, upper;
};

/// Unknowns x = (d, λ), d = q_cmd − q_cmd⁻.
[[maybe_unused]] Program make_program(const control::RobotLimits& robot, const ContactTick& t, const control::ContactQpOptions& options) {
  const Index n = t.q.size(), m = t.J_u.rows();
  const Eigen::VectorXd offset = t.q_cmd - t.q, wanted = t.q_ref - t.q_cmd;
  Program p;
  p.H = Eigen::MatrixXd::Zero(n + m, n + m);  // λ costs nothing: (C.4) fixes it
  p.H.topLeftCorner(n, n).diagonal().setConstant(1 + t.damping);
  p.g = Eigen::VectorXd::Zero(n + m);
  p.g.head(n) = -wanted;
  const Eigen::MatrixXd G = t.J_u * robot.stiffness.cwiseInverse().asDiagonal() * t.J_u.transpose();
  const Eigen::VectorXd least = Eigen::VectorXd::Constant(m, options.least_lever * options.least_lever / robot.stiffness.maxCoeff());
  const Eigen::VectorXd C = options.contact_compliance * G.diagonal().cwiseMax(least);
  p.A.resize(m, n + m);
  p.A << t.J_u, G + Eigen::MatrixXd(C.asDiagonal());
  p.b = C.cwiseProduct(t.lambda) - t.J_u * offset;
  p.lower.resize(n + m);
  p.upper.resize(n + m);
  p.lower.head(n) = (-robot.rate).cwiseMax(robot.lower - t.q_cmd);
  p.upper.head(n) = robot.rate.cwiseMin(robot.upper - t.q_cmd);
  const Eigen::VectorXd along = t.J_u * (t.q_ref - t.q);
  for (Index i = 0; i < m; ++i) p.lower[n + i] = options.unilateral && along[i] < 0 ? 0 : -1e20;
  p.upper.tail(m) = t.lambda_max;
  return p;
}

/// Times solve(program) of all ticks, `repeat` times. @param solve  returns whether the program was solved
template <class Solve>
[[maybe_unused]] GeneralQp time_solver(std::string name, const control::RobotLimits& robot, const std::vector<ContactTick>& ticks,
                                       const control::ContactQpOptions& options, int repeat, Solve&& solve) {
  GeneralQp out{std::move(name), {}, 0};
  for (int r = 0; r < repeat; ++r)
    for (const ContactTick& tick : ticks) {
      const Program p = make_program(robot, tick, options);
      const auto start = Clock::now();
      const bool solved = solve(p);
      out.seconds.push_back(std::chrono::duration<double>(Clock::now() - start).count());
      if (r == 0) out.unsolved += !solved;
    }
  return out;
}

#ifdef STICTION_HAS_HIGHS
/// The active-set method for quadratic programs of HiGHS, through its C interface. The library is loaded here and never linked: only this row needs it.
class Highs {
 public:
  Highs() : library_(dlopen(STICTION_HIGHS_LIBRARY, RTLD_NOW | RTLD_LOCAL)) {
    if (library_ == nullptr) return;
    load("Highs_create", create_), load("Highs_destroy", destroy_), load("Highs_passModel", pass_), load("Highs_run", run_);
    load("Highs_getModelStatus", status_), load("Highs_setBoolOptionValue", set_bool_), load("Highs_setDoubleOptionValue", set_double_);
    highs_ = create_();
    set_bool_(highs_, "output_flag", 0);
    set_double_(highs_, "primal_feasibility_tolerance", kResidual);
    set_double_(highs_, "dual_feasibility_tolerance", kResidual);
  }
  ~Highs() {
    if (highs_ != nullptr) destroy_(highs_);
  }
  Highs(const Highs&) = delete;
  Highs& operator=(const Highs&) = delete;
  bool is_loaded() const { return highs_ != nullptr; }

  bool operator()(const Program& p) {
    const Index n = p.g.size(), m = p.b.size();
    starts_.resize(static_cast<std::size_t>(m)), columns_.resize(static_cast<std::size_t>(n * m));
    for (Index i = 0; i < m; ++i) starts_[static_cast<std::size_t>(i)] = static_cast<HighsInt>(i * n);
    for (Index k = 0; k < n * m; ++k) columns_[static_cast<std::size_t>(k)] = static_cast<HighsInt>(k % n);
    fill_hessian(p);
    const auto size = [](Index k) { return static_cast<HighsInt>(k); };
    pass_(highs_, size(n), size(m), size(n * m), static_cast<HighsInt>(hessian_.size()), kHighsMatrixFormatRowwise,
          kHighsHessianFormatTriangular, kHighsObjSenseMinimize, 0, p.g.data(), p.lower.data(), p.upper.data(), p.b.data(), p.b.data(),
          starts_.data(), columns_.data(), p.A.data(), hessian_starts_.data(), hessian_rows_.data(), hessian_.data(), nullptr);
    run_(highs_);
    return status_(highs_) == kHighsModelStatusOptimal;
  }

 private:
  /// The lower triangle by columns.
  void fill_hessian(const Program& p) {
    hessian_starts_.clear(), hessian_rows_.clear(), hessian_.clear();
    for (Index column = 0; column < p.H.cols(); ++column) {
      hessian_starts_.push_back(static_cast<HighsInt>(hessian_.size()));
      for (Index row = column; row < p.H.rows(); ++row)
        if (p.H(row, column) != 0) hessian_rows_.push_back(static_cast<HighsInt>(row)), hessian_.push_back(p.H(row, column));
    }
  }

  template <class Function>
  void load(const char* name, Function*& out) {
    out = reinterpret_cast<Function*>(dlsym(library_, name));
  }

  void* library_;
  void* highs_ = nullptr;
  decltype(Highs_create)* create_ = nullptr;
  decltype(Highs_destroy)* destroy_ = nullptr;
  decltype(Highs_passModel)* pass_ = nullptr;
  decltype(Highs_run)* run_ = nullptr;
  decltype(Highs_getModelStatus)* status_ = nullptr;
  decltype(Highs_setBoolOptionValue)* set_bool_ = nullptr;
  decltype(Highs_setDoubleOptionValue)* set_double_ = nullptr;
  std::vector<HighsInt> starts_, columns_, hessian_starts_, hessian_rows_;
  std::vector<double> hessian_;
};
#endif

}  // namespace

std::vector<GeneralQp> time_general_qps([[maybe_unused]] const control::RobotLimits& robot, const std::vector<ContactTick>& ticks,
                                        [[maybe_unused]] const control::ContactQpOptions& options, [[maybe_unused]] int repeat) {
  std::vector<GeneralQp> out;
  if (ticks.empty()) return out;
#ifdef STICTION_HAS_PROXQP
  const Index n = ticks[0].q.size(), m = ticks[0].J_u.rows();
  ProxQp proxqp(n + m, m, n + m, {.residual = kResidual, .max_iterations = 10000});
  QuadraticProgram program{.C = Eigen::MatrixXd::Identity(n + m, n + m)};
  out.push_back(time_solver("proxqp", robot, ticks, options, repeat, [&](const Program& p) {
    program.H = p.H, program.g = p.g, program.A = p.A, program.b = p.b, program.lower = p.lower, program.upper = p.upper;
    return proxqp.solve(program);
  }));
#endif
#ifdef STICTION_HAS_HIGHS
  Highs highs;
  if (highs.is_loaded()) out.push_back(time_solver("highs", robot, ticks, options, repeat, highs));
#endif
  return out;
}

}  // namespace stiction::bench
