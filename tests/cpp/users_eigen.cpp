// A user's own Kalman filter: Eigen, compiled for this processor as robotics projects do.
#include <Eigen/Cholesky>

double users_gain();

namespace {

Eigen::Matrix4d gain(const Eigen::Matrix4d& s, const Eigen::Matrix4d& p) {
  const Eigen::LDLT<Eigen::Matrix4d> solver(s);
  const Eigen::Matrix4d half = solver.solve(p);
  return solver.solve(half.transpose());
}

Eigen::Vector4d state(const Eigen::Matrix4d& s, const Eigen::Vector4d& z) {
  const Eigen::LDLT<Eigen::Matrix4d> solver(s);
  return solver.solve(z);
}

}  // namespace

double users_gain() {
  const Eigen::Matrix4d s = 3 * Eigen::Matrix4d::Identity();
  return gain(s, s).trace() + state(s, Eigen::Vector4d::Ones()).sum();
}
