package knap;

import java.io.DataInput;
import java.io.DataOutput;
import java.io.IOException;
import java.nio.charset.StandardCharsets;
import lcm.lcm.LCMEncodable;

/**
 * What liblcm sends to itself on LCM_SELF_TEST when it opens an address: the 13 characters "lcm self test" and nothing
 * else. It is no LCM type, so lcm-gen cannot make this class. lcm-spy looks a type up by its first eight bytes, and
 * these are always "lcm self".
 */
public final class lcm_self_test_t implements LCMEncodable {
  public static final long LCM_FINGERPRINT = 0x6c636d2073656c66L;
  private static final int REST_SIZE = 5;

  public String text;

  public lcm_self_test_t(DataInput in) throws IOException {
    if (in.readLong() != LCM_FINGERPRINT) {
      throw new IOException("LCM self test: does not begin with 'lcm self'");
    }
    _decodeRecursive(in);
  }

  @Override
  public void _decodeRecursive(DataInput in) throws IOException {
    byte[] rest = new byte[REST_SIZE];
    in.readFully(rest);
    text = "lcm self" + new String(rest, StandardCharsets.US_ASCII);
  }

  @Override
  public void encode(DataOutput out) throws IOException {
    out.write(text.getBytes(StandardCharsets.US_ASCII));
  }

  @Override
  public void _encodeRecursive(DataOutput out) throws IOException {
    out.write(text.substring(8).getBytes(StandardCharsets.US_ASCII));
  }
}
