package knap.worker;

import java.io.IOException;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.nio.charset.StandardCharsets;
import java.security.GeneralSecurityException;
import java.security.MessageDigest;
import java.util.Arrays;
import javax.crypto.Mac;
import javax.crypto.spec.SecretKeySpec;
import lcm.lcm.LCMDataOutputStream;
import lcm.lcm.LCMEncodable;

/** Bytes of the wire: digests, the checks before decoding, content ids (docs/protocol.md, sections 2 and 3). */
final class Wire {
  static final int MAX_MESSAGE = 1300;
  static final int DIGEST = 16;
  static final int VALUES_PER_PART = 96;
  static final int MAX_VALUES = 1 << 20;
  static final int CHUNK = 1024;
  static final int MAX_BUNDLE = 64 << 20;

  private final Mac mac;

  Wire(byte[] key) throws GeneralSecurityException {
    mac = Mac.getInstance("HmacSHA256");
    mac.init(new SecretKeySpec(key, "HmacSHA256"));
  }

  /** The encoded message; its digest field must be zeros and its last one, its counts must fit its arrays. */
  synchronized byte[] seal(LCMEncodable message) throws IOException {
    LCMDataOutputStream out = new LCMDataOutputStream();
    message.encode(out);
    byte[] bytes = out.toByteArray();
    if (bytes.length > MAX_MESSAGE) throw new IllegalStateException("a message of " + bytes.length + " bytes");
    System.arraycopy(mac.doFinal(bytes), 0, bytes, bytes.length - DIGEST, DIGEST);
    return bytes;
  }

  /** Whether size, type and digest are those of a message from a holder of the key. */
  synchronized boolean verify(byte[] bytes, long fingerprint) {
    if (bytes.length > MAX_MESSAGE || bytes.length < 8 + DIGEST) return false;
    if (ByteBuffer.wrap(bytes).getLong(0) != fingerprint) return false;
    byte[] zeroed = Arrays.copyOf(bytes, bytes.length);
    Arrays.fill(zeroed, bytes.length - DIGEST, bytes.length, (byte) 0);
    byte[] expected = Arrays.copyOf(mac.doFinal(zeroed), DIGEST);
    return MessageDigest.isEqual(expected, Arrays.copyOfRange(bytes, bytes.length - DIGEST, bytes.length));
  }

  /** The 32-bit count at this offset, checked before the generated decoder allocates by it. */
  static int takeCount(byte[] bytes, int offset, int limit) throws IOException {
    if (offset + 4 > bytes.length) throw new IOException("the message ends inside its lengths");
    int count = ByteBuffer.wrap(bytes).getInt(offset);
    if (count < 0 || count > limit) throw new IOException("a length of " + count + ", at most " + limit);
    return count;
  }

  /** The counts of a rollout_request_t. */
  static void checkRequest(byte[] bytes) throws IOException {
    int assignments = takeCount(bytes, 48, 16);
    takeCount(bytes, 52, 8 * 32);
    int offset = 88;
    for (int i = 0; i < assignments; ++i) {
      for (int size = 8; size < 32; size += 4) takeCount(bytes, offset + size, MAX_VALUES);
      offset += 68 + 8 * takeCount(bytes, offset + 32, VALUES_PER_PART);
    }
  }

  static byte[] sha256(byte[] bytes) throws GeneralSecurityException {
    return MessageDigest.getInstance("SHA-256").digest(bytes);
  }

  static byte[] calcRequestId(String engine, byte[] scenario, double[] theta, double[] controls, double[] reference,
      double[] variation, double[] nodes, boolean gradient) throws GeneralSecurityException {
    int values = theta.length + controls.length + reference.length + variation.length + nodes.length;
    ByteBuffer content = ByteBuffer.allocate(256 + 8 * values).order(ByteOrder.LITTLE_ENDIAN);
    putString(content, "knap-request-3");
    putString(content, engine);
    content.put(scenario);
    for (double[] list : new double[][] {theta, controls, reference, variation, nodes}) {
      content.putLong(list.length);
      for (double value : list) content.putLong(Double.doubleToRawLongBits(value));
    }
    content.putLong(reference.length == 0 ? 0 : 1);
    content.putLong(gradient ? 1 : 0);
    return sha256(Arrays.copyOf(content.array(), content.position()));
  }

  private static void putString(ByteBuffer content, String text) {
    byte[] bytes = text.getBytes(StandardCharsets.US_ASCII);
    content.putLong(bytes.length);
    content.put(bytes);
  }

  static String hex(byte[] id) {
    StringBuilder text = new StringBuilder();
    for (byte b : id) text.append(String.format("%02x", b));
    return text.toString();
  }
}
