#include "sim/contact/planar_moments.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace knap {

using Eigen::Vector2d;

namespace {

// A plane that a cylinder's axis meets under less than this angle [rad] cuts a strip out of it.
constexpr double kParallel = 1e-12;

// The part t1 < t < t2 of an edge inside the conic.
struct Portion {
  Vector2d begin, end;
  bool enters = false;  // begins on the conic, not at a corner
  bool leaves = false;
};

// q along p + t d is a t² + 2 b t + c with a ≤ 0.
bool FindPortion(const Vector2d& p, const Vector2d& q, const Conic& conic, Portion* out) {
  const Vector2d d = q - p;
  const double slope = conic.alpha * d.x();
  const double a = -(d.y() * d.y() + slope * slope);
  const double b = conic.b * d.x() - p.y() * d.y() - conic.alpha * p.x() * slope;
  const double c = conic.At(p);
  double t1 = 0.0;
  double t2 = 1.0;
  if (a < 0.0) {
    const double discriminant = b * b - a * c;
    if (!(discriminant > 0.0)) return false;
    // Of the two roots the one without cancellation first.
    const double big = -b - std::copysign(std::sqrt(discriminant), b);
    double low = big / a;
    double high = big == 0.0 ? 0.0 : c / big;
    if (low > high) std::swap(low, high);
    t1 = std::max(t1, low);
    t2 = std::min(t2, high);
  } else if (!(c > 0.0)) {
    return false;
  }
  if (!(t2 > t1)) return false;
  out->enters = t1 > 0.0;
  out->leaves = t2 < 1.0;
  out->begin = out->enters ? Vector2d(p + t1 * d) : p;
  out->end = out->leaves ? Vector2d(p + t2 * d) : q;
  return true;
}

// The corner after the k-th.
const Vector2d& GetNext(PlanePolygon polygon, std::size_t k) { return polygon[k + 1 < polygon.size() ? k + 1 : 0]; }

bool Contains(PlanePolygon polygon, const Vector2d& x) {
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Vector2d& p = polygon[k];
    const Vector2d e = GetNext(polygon, k) - p;
    if (!(e.x() * (x.y() - p.y()) - e.y() * (x.x() - p.x()) > 0.0)) return false;
  }
  return true;
}

}  // namespace

template <int degree>
void PlanarMoments::Add(double u, double w, double dw) {
  constexpr std::array<double, kDegree + 1> kShare = {1.0, 1.0 / 2.0, 1.0 / 3.0, 1.0 / 4.0, 1.0 / 5.0};
  double power_u = u * dw;  // u^(i+1) dw
  for (int i = 0; i <= degree; ++i) {
    double term = power_u * kShare[i];
    for (int j = 0; i + j <= degree; ++j) {
      m_[Index(i, j)] += term;
      term *= w;
    }
    power_u *= u;
  }
}

template <int degree>
void PlanarMoments::AddEdge(const Vector2d& p, const Vector2d& q) {
  const Vector2d d = q - p;
  for (int g = 0; g < 3; ++g)
    Add<degree>(p.x() + kEdgeAt[g] * d.x(), p.y() + kEdgeAt[g] * d.y(), kEdgeWeight[g] * d.y());
}

void PlanarMoments::AddArc(double center_u, double a, double b, double begin, double span) {
  const int pieces = std::max(1, static_cast<int>(std::ceil(span / (0.5 * std::numbers::pi) - 1e-9)));
  const double half = 0.5 * span / pieces;
  std::array<Vector2d, 4> offset;  // cosine and sine
  for (int g = 0; g < 4; ++g) offset[g] = {std::cos(half * kArcAt[g]), std::sin(half * kArcAt[g])};
  for (int piece = 0; piece < pieces; ++piece) {
    const double phi = begin + (2 * piece + 1) * half;
    const Vector2d middle(std::cos(phi), std::sin(phi));
    for (int g = 0; g < 8; ++g) {
      const Vector2d turn(offset[g % 4].x(), g < 4 ? -offset[g].y() : offset[g - 4].y());
      const double cosine = middle.x() * turn.x() - middle.y() * turn.y();
      const double sine = middle.y() * turn.x() + middle.x() * turn.y();
      Add<kDegree>(center_u + a * cosine, b * sine, b * cosine * half * kArcWeight[g % 4]);
    }
  }
}

void PlanarMoments::AddOpenArc(double vertex, double R, double sign, double alpha2, double begin, double end) {
  const double middle = 0.5 * (begin + end);
  const double half = 0.5 * (end - begin);
  for (int g = 0; g < 8; ++g) {
    const double sigma = middle + (g < 4 ? -half : half) * kArcAt[g % 4];
    const double root = std::sqrt(1.0 - alpha2 * sigma * sigma);
    const double dw = 2.0 * R * (1.0 - 2.0 * alpha2 * sigma * sigma) / root;
    Add<kDegree>(vertex + sign * 2.0 * R * sigma * sigma, 2.0 * R * sigma * root, dw * half * kArcWeight[g % 4]);
  }
}

Eigen::Matrix<double, 6, 6> PlanarMoments::MakeGram() const {
  // Where the product of two monomials stands among the moments.
  constexpr std::array<int, 36> kIndex = {0, 1, 2, 3,  4,  5,  1, 3, 4, 6,  7,  8,  2, 4, 5, 7,  8,  9,
                                          3, 6, 7, 10, 11, 12, 4, 7, 8, 11, 12, 13, 5, 8, 9, 12, 13, 14};
  Eigen::Matrix<double, 6, 6> gram;
  for (int k = 0; k < 36; ++k) gram.data()[k] = m_[kIndex[k]];
  return gram;
}

PlanarMoments CalcPolygonMoments(PlanePolygon polygon) {
  PlanarMoments moments;
  for (std::size_t k = 0; k < polygon.size(); ++k) moments.AddEdge<3>(polygon[k], GetNext(polygon, k));
  return moments;
}

namespace {

// The arcs of one conic.
class ConicArcs {
 public:
  explicit ConicArcs(const Conic& conic) : conic_(conic), alpha2_(conic.alpha * conic.alpha) {
    is_strip_ = !conic.is_open && std::abs(conic.alpha) < kParallel;
    if (is_strip_) {
      half_width2_ = conic.c;
    } else if (conic.is_open) {
      R_ = std::sqrt(std::max(0.0, conic.b * conic.b + alpha2_ * conic.c));
      sign_ = conic.b < 0.0 ? -1.0 : 1.0;
      vertex_ = -conic.c / (conic.b + sign_ * R_);
      half_width2_ = R_;
    } else {
      center_u_ = conic.b / alpha2_;
      half_width2_ = conic.c + conic.b * center_u_;
      b_ = std::sqrt(std::max(0.0, half_width2_));
      a_ = b_ / std::abs(conic.alpha);
    }
  }

  bool exists() const { return half_width2_ > 0.0; }
  // Whether the conic bounds a region of its own, and then its middle.
  bool is_closed() const { return !is_strip_ && !conic_.is_open; }
  Vector2d center() const { return {center_u_, 0.0}; }
  void AddAll(PlanarMoments* out) const { out->AddArc(center_u_, a_, b_, 0.0, 2.0 * std::numbers::pi); }

  // From p to q, both on it, with the region to the left. A strip's own sides run along u: nothing of ∮ … dw comes from
  // them.
  void AddBetween(const Vector2d& p, const Vector2d& q, PlanarMoments* out) const {
    if (is_strip_) return;
    if (conic_.is_open) return out->AddOpenArc(vertex_, R_, sign_, alpha2_, Sigma(p), Sigma(q));
    const auto angle = [&](const Vector2d& x) { return std::atan2(x.y() / b_, (x.x() - center_u_) / a_); };
    const double begin = angle(p);
    double span = angle(q) - begin;
    if (span < 0.0) span += 2.0 * std::numbers::pi;
    // Where the two points are one up to rounding there is no arc, and none all the way around.
    if (span > 2.0 * std::numbers::pi - 1e-9) return;
    out->AddArc(center_u_, a_, b_, begin, span);
  }

 private:
  // The cosine of the angle from the nearer vertex is (b − alpha² u)/R.
  double Sigma(const Vector2d& x) const {
    const double cosine = sign_ * (conic_.b - alpha2_ * x.x()) / R_;
    return x.y() / (2.0 * R_ * std::sqrt(std::max(0.5, 0.5 + 0.5 * cosine)));
  }

  const Conic& conic_;
  double alpha2_;
  bool is_strip_ = false;
  double half_width2_ = 0.0;                    // > 0 where there is anything inside
  double center_u_ = 0.0, a_ = 0.0, b_ = 0.0;   // of an ellipse
  double vertex_ = 0.0, R_ = 0.0, sign_ = 1.0;  // of an open conic
};

}  // namespace

PlanarMoments CalcConicMoments(PlanePolygon polygon, const Conic& conic) {
  PlanarMoments moments;
  const ConicArcs arcs(conic);
  if (!arcs.exists()) return moments;
  // Both are convex: where all corners are inside, all is, and nothing is cut.
  if (std::all_of(polygon.begin(), polygon.end(), [&](const Vector2d& x) { return conic.At(x) > 0.0; })) {
    for (std::size_t k = 0; k < polygon.size(); ++k) {
      moments.AddEdge<PlanarMoments::kDegree>(polygon[k], GetNext(polygon, k));
    }
    return moments;
  }
  // A portion, and the arc from its end to where the next one begins.
  const auto add = [&](const Portion& portion, const Portion& next) {
    moments.AddEdge<PlanarMoments::kDegree>(portion.begin, portion.end);
    if (portion.leaves || next.enters) arcs.AddBetween(portion.end, next.begin, &moments);
  };
  Portion first;
  Portion last;
  bool meets = false;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    Portion portion;
    if (!FindPortion(polygon[k], GetNext(polygon, k), conic, &portion)) continue;
    if (meets) {
      add(last, portion);
    } else {
      first = portion;
    }
    last = portion;
    meets = true;
  }
  if (meets) {
    add(last, first);
  } else if (arcs.is_closed() && Contains(polygon, arcs.center())) {
    arcs.AddAll(&moments);
  }
  return moments;
}

}  // namespace knap
