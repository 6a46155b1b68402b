package knap.worker;

import java.security.GeneralSecurityException;
import java.util.Arrays;
import java.util.BitSet;
import knap.scenario_t;

/** Gathers one scenario's pieces (docs/protocol.md, section 4, "Fetch the scenario"). */
final class ScenarioFetch {
  private static final int PIECES_AT_A_TIME = 32;
  private static final long RETRY_NS = 100_000_000L;

  final byte[] scenario;
  private byte[] bundle;  // null until the first piece tells its length
  private final BitSet have = new BitSet();
  private int pieces;
  private int[] asked = new int[0];
  private long askedAt;

  ScenarioFetch(byte[] scenario) {
    this.scenario = scenario;
  }

  void add(scenario_t piece) {
    if (!Arrays.equals(piece.scenario, scenario)) return;
    int count = (piece.total_size + Wire.CHUNK - 1) / Wire.CHUNK;
    if (piece.total_size <= 0 || piece.total_size > Wire.MAX_BUNDLE || piece.chunk_count != count) return;
    if (piece.chunk < 0 || piece.chunk >= count) return;
    int begin = piece.chunk * Wire.CHUNK;
    if (piece.data.length != Math.min(Wire.CHUNK, piece.total_size - begin)) return;
    if (bundle == null) {
      bundle = new byte[piece.total_size];
      pieces = count;
    }
    if (bundle.length != piece.total_size) return;
    System.arraycopy(piece.data, 0, bundle, begin, piece.data.length);
    have.set(piece.chunk);
  }

  /** Whether the whole has come and is what was wanted; if it is not, starts again. */
  boolean isComplete() throws GeneralSecurityException {
    if (bundle == null || have.cardinality() < pieces) return false;
    if (Arrays.equals(Wire.sha256(bundle), scenario)) return true;
    bundle = null;
    have.clear();
    asked = new int[0];
    return false;
  }

  /** The pieces to ask for now; empty while what was asked for may still come. */
  int[] chooseWanted() {
    int[] missing = Arrays.stream(asked).filter(piece -> !have.get(piece)).toArray();
    long now = System.nanoTime();
    if (missing.length > 0 && now - askedAt < RETRY_NS) return new int[0];
    if (missing.length == 0 && bundle == null) {
      missing = new int[] {0};
    } else if (missing.length == 0) {
      missing = new int[Math.min(PIECES_AT_A_TIME, pieces - have.cardinality())];
      int piece = -1;
      for (int i = 0; i < missing.length; ++i) missing[i] = piece = have.nextClearBit(piece + 1);
    }
    asked = missing;
    askedAt = now;
    return missing;
  }
}
