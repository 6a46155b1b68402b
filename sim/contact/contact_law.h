// The force at one point of contact between a body B and a surface on a body S. All vectors in one frame.
//
// The elastic part is given: N_e, its size, and n, the unit normal out of S. With u the velocity of B's material point
// at the contact relative to S,
//
//   N = N_e ramp(1 − d n·u)             Hunt–Crossley damping, never adhesive [Hunt & Crossley 1975]
//   s = (I − n nᵀ) u                    slip velocity
//   f = N (n + tau)                     on B; |tau| ≤ mu: inside the cone of the normal force alone
//
// Friction has two laws:
//
//   regularised    tau = −mu s / sqrt(|s|² + v_s²), where slip_speed v_s alone counts (stick_distance 0)
//   bristle        z = (I − n nᵀ) z_previous + h s,   q = sigma(|z|/z_s) z_s z/|z|,   tau = −mu q / z_s
//
// A bristle is a tangential spring between the two surfaces that bends by z and slides when it would bend by more than
// z_s = stick_distance; h is the step. sigma(y) = y up to y0 = 0.85, and y0 + (1 − y0) t (1 + t⁴)^(−1/4) beyond, with
// t = (y − y0)/(1 − y0): four times differentiable, below 1. Up to 85% of the bound nothing slides, so what rests keeps
// its bend and does not creep. What is handed to the next step is q, faded out where N_e falls below N_light, so that
// letting go of a surface and touching it again is smooth.
//
// Rolling resistance of a ball of radius r with relative angular velocity w:
//
//   m = −c_r r N w_t / sqrt(|w_t|² + (v_s/r)²),   w_t = (I − n nᵀ) w
//
// Everything is C¹ in all arguments, also at onset, where N_e vanishes with zero slope.
#pragma once

#include <Eigen/Dense>

namespace knap {

struct ContactMaterial {
  double stiffness = 0.0;           // E, pressure per depth [N/m³]
  double damping = 0.0;             // d [s/m]
  double friction = 0.0;            // mu [-]
  double rolling_resistance = 0.0;  // c_r, resisting moment over r N [-]
  double slip_speed = 1e-3;         // v_s, where regularised friction reaches 1/√2 of its bound [m/s]
  double stick_distance = 0.0;      // z_s [m]; 0: regularised friction
};

struct PointForce {
  double N = 0.0;
  Eigen::Vector3d f = Eigen::Vector3d::Zero();        // on B [N]
  Eigen::Vector3d bristle = Eigen::Vector3d::Zero();  // q for the next step [m]; zero under regularised friction
};

// Derivatives; gradients of N as columns.
struct PointForceJacobian {
  double dN_dNe;
  Eigen::Vector3d dN_dn, dN_du;
  Eigen::Vector3d df_dNe;
  Eigen::Matrix3d df_dn, df_du, df_dz;  // z: the previous bristle
  Eigen::Vector3d dq_dNe;
  Eigen::Matrix3d dq_dn, dq_du, dq_dz;
};

// N_e > 0, N_light > 0. `jacobian` may be null.
PointForce CalcPointForce(const ContactMaterial& material, double N_e, double N_light, const Eigen::Vector3d& n,
                          const Eigen::Vector3d& u, const Eigen::Vector3d& z_previous, double h,
                          PointForceJacobian* jacobian);

struct RollingMoment {
  Eigen::Vector3d m;
  Eigen::Vector3d dm_dN;
  Eigen::Matrix3d dm_dn, dm_dw;
};
RollingMoment CalcRollingMoment(const ContactMaterial& material, double r, double N, const Eigen::Vector3d& n,
                                const Eigen::Vector3d& w);

}  // namespace knap
