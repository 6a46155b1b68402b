package knap.worker;

/**
 * The engine `bowl`: the same closed form, operation by operation, as tests/worker/bowl_engine.h. Its theta are the
 * design parameters and then the controls, if any.
 */
final class Bowl {
  static final String NAME = "bowl";
  static final int STEPS = 100;

  double loss;
  boolean success;
  double[] gradient;

  static Bowl run(double[] theta, double[] reference, double[] variation, boolean wantsGradient) {
    Bowl answer = new Bowl();
    answer.gradient = new double[wantsGradient ? theta.length : 0];
    for (int i = 0; i < theta.length; ++i) {
      boolean task = reference.length == 0;
      double weight = task ? 1.0 + 0.5 * i : 1.0;
      double target = task ? 0.01 + 0.005 * i : reference[i];
      if (task && variation.length > 0) target = target + 0.1 * variation[i % variation.length];
      double error = theta[i] - target;
      answer.loss = answer.loss + 0.5 * weight * error * error;
      if (wantsGradient) answer.gradient[i] = weight * error;
    }
    answer.success = answer.loss < 0.001;
    return answer;
  }
}
