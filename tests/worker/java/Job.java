package knap.worker;

import java.util.Arrays;
import java.util.BitSet;
import knap.assignment_t;

/** One request, put together from its parts. */
final class Job {
  final byte[] id;
  final byte[] scenario;
  final int attempt;
  final boolean gradient;
  private final int thetaSize;
  private final int controlSize;
  private final int referenceSize;
  private final int variationSize;
  private final double[] values;
  private final BitSet have = new BitSet();

  Job(byte[] scenario, assignment_t head) {
    this.scenario = scenario;
    id = head.id;
    attempt = head.attempt;
    gradient = head.gradient != 0;
    thetaSize = head.theta_size;
    controlSize = head.control_size;
    referenceSize = head.reference_size;
    variationSize = head.variation_size;
    values = new double[countValues(head)];
  }

  /** Adds one part; one that cannot belong here is ignored. */
  void add(assignment_t part) {
    int first = part.first_value;
    if (countValues(part) != values.length) return;
    if (first % Wire.VALUES_PER_PART != 0 || first > values.length) return;
    if (part.values.length != Math.min(Wire.VALUES_PER_PART, values.length - first)) return;
    System.arraycopy(part.values, 0, values, first, part.values.length);
    have.set(first / Wire.VALUES_PER_PART);
  }

  boolean isComplete() {
    int parts = Math.max(1, (values.length + Wire.VALUES_PER_PART - 1) / Wire.VALUES_PER_PART);
    return have.cardinality() == parts;
  }

  double[] theta() {
    return Arrays.copyOfRange(values, 0, thetaSize);
  }

  /** Design parameters, then controls. */
  double[] decided() {
    return Arrays.copyOfRange(values, 0, thetaSize + controlSize);
  }

  double[] controls() {
    return Arrays.copyOfRange(values, thetaSize, thetaSize + controlSize);
  }

  double[] reference() {
    int begin = thetaSize + controlSize;
    return Arrays.copyOfRange(values, begin, begin + referenceSize);
  }

  double[] variation() {
    int begin = thetaSize + controlSize + referenceSize;
    return Arrays.copyOfRange(values, begin, begin + variationSize);
  }

  double[] nodes() {
    return Arrays.copyOfRange(values, thetaSize + controlSize + referenceSize + variationSize, values.length);
  }

  private static int countValues(assignment_t head) {
    return head.theta_size + head.control_size + head.reference_size + head.variation_size + head.nodes_size;
  }
}
