/// @file  An extended Kalman filter of Orocos BFL whose models are given as functions of Eigen vectors. Needs
/// liborocos-bfl-dev.
#pragma once

#include <bfl/filter/extendedkalmanfilter.h>
#include <bfl/model/analyticsystemmodel_gaussianuncertainty.h>
#include <bfl/model/linearanalyticmeasurementmodel_gaussianuncertainty.h>
#include <bfl/pdf/analyticconditionalgaussian_additivenoise.h>
#include <bfl/pdf/linearanalyticconditionalgaussian.h>

#include <Eigen/Core>
#include <functional>

namespace motionlab::test {

namespace bfl {

using MatrixWrapper::ColumnVector;
using MatrixWrapper::Matrix;
using MatrixWrapper::SymmetricMatrix;

template <class To, class From>
void copy_vector(To& to, const From& from, unsigned n) {
  for (unsigned i = 0; i < n; ++i) to(i + 1) = from[i];
}

inline ColumnVector column(const Eigen::VectorXd& v) {
  ColumnVector to(static_cast<int>(v.size()));
  copy_vector(to, v, static_cast<unsigned>(v.size()));
  return to;
}

inline Matrix matrix(const Eigen::MatrixXd& M) {
  Matrix to(static_cast<int>(M.rows()), static_cast<int>(M.cols()));
  for (unsigned i = 0; i < M.rows(); ++i) {
    for (unsigned j = 0; j < M.cols(); ++j) to(i + 1, j + 1) = M(i, j);
  }
  return to;
}

inline SymmetricMatrix diagonal(const Eigen::VectorXd& variances) {
  SymmetricMatrix to(static_cast<int>(variances.size()));
  to = 0.0;
  for (unsigned i = 0; i < variances.size(); ++i) to(i + 1, i + 1) = variances[i];
  return to;
}

inline BFL::Gaussian noise(const Eigen::VectorXd& variances) {
  return {column(Eigen::VectorXd::Zero(variances.size())), diagonal(variances)};
}

/// x ← f(x, u) + noise, and F = df/dx.
class Transition : public BFL::AnalyticConditionalGaussianAdditiveNoise {
 public:
  using Mean = std::function<ColumnVector(const ColumnVector& x, const ColumnVector& u)>;
  using Derivative = std::function<Matrix(const ColumnVector& x, const ColumnVector& u)>;

  Transition(const Eigen::VectorXd& variances, Mean f, Derivative F)
      : AnalyticConditionalGaussianAdditiveNoise(noise(variances), 2), f_(std::move(f)), F_(std::move(F)) {}

  ColumnVector ExpectedValueGet() const override {
    return f_(ConditionalArgumentGet(0), ConditionalArgumentGet(1));
  }
  Matrix dfGet(unsigned) const override { return F_(ConditionalArgumentGet(0), ConditionalArgumentGet(1)); }

 private:
  Mean f_;
  Derivative F_;
};

}  // namespace bfl

/// Update with z = H x + noise, then predict, as our filters of the thesis do.
class BflFilter {
 public:
  BflFilter(const Eigen::VectorXd& x, const Eigen::VectorXd& variances, const Eigen::MatrixXd& H,
            const Eigen::VectorXd& R, bfl::Transition& transition)
      : prior_(bfl::column(x), bfl::diagonal(variances)),
        measured_(bfl::matrix(H), bfl::noise(R)),
        measurement_(&measured_),
        system_(&transition),
        filter_(&prior_) {
    filter_.AllocateMeasModelExt(static_cast<unsigned>(R.size()));
  }

  void step(const bfl::ColumnVector& z, const bfl::ColumnVector& u) {
    filter_.Update(&measurement_, z);
    filter_.Update(&system_, u);
  }
  /// Largest difference of state and of covariance.
  template <class State>
  [[nodiscard]] double difference(const State& ours) {
    const bfl::ColumnVector x = filter_.PostGet()->ExpectedValueGet();
    const bfl::SymmetricMatrix P = filter_.PostGet()->CovarianceGet();
    double largest = 0;
    for (unsigned i = 0; i < ours.x.size(); ++i) {
      largest = std::max(largest, std::abs(x(i + 1) - ours.x[i]));
      for (unsigned j = 0; j < ours.x.size(); ++j) {
        largest = std::max(largest, std::abs(P(i + 1, j + 1) - ours.P(i, j)));
      }
    }
    return largest;
  }

 private:
  BFL::Gaussian prior_;
  BFL::LinearAnalyticConditionalGaussian measured_;
  BFL::LinearAnalyticMeasurementModelGaussianUncertainty measurement_;
  BFL::AnalyticSystemModelGaussianUncertainty system_;
  BFL::ExtendedKalmanFilter filter_;
};

}  // namespace motionlab::test
