package knap.worker;

import java.io.IOException;
import java.net.InetAddress;
import java.nio.ByteBuffer;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Paths;
import java.security.GeneralSecurityException;
import java.security.SecureRandom;
import java.util.ArrayDeque;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.HashSet;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.Set;
import java.util.concurrent.ArrayBlockingQueue;
import java.util.concurrent.TimeUnit;
import knap.assignment_t;
import knap.control_t;
import knap.rollout_request_t;
import knap.rollout_result_t;
import knap.run_status_t;
import knap.scenario_t;
import knap.worker_status_t;
import lcm.lcm.LCM;
import lcm.lcm.LCMDataInputStream;

/**
 * A worker written after docs/protocol.md alone, to show that the page is enough; engine `bowl`.
 * Arguments: URL KEY_FILE NAME STEP_US (wall time of each of a rollout's 100 steps).
 */
public final class JavaWorker {
  private static final long STATUS_NS = 250_000_000L;
  private static final long RESULT_RETRY_NS = 200_000_000L;
  private static final long RUN_SILENCE_NS = 2_000_000_000L;
  private static final int MAX_QUEUE = 16;
  private static final int MAX_KEPT = 512;

  private static final class Message {
    String channel;
    byte[] bytes;
  }

  /** An answer and whether it must still be repeated. */
  private static final class Kept {
    List<rollout_result_t> parts = new ArrayList<>();
    boolean acknowledged;
    long sentAt;
  }

  private final Wire wire;
  private final LCM lcm;
  private final String name;
  private final String host;
  private final int stepUs;
  private final long instance;
  private final ArrayBlockingQueue<Message> inbox = new ArrayBlockingQueue<>(4096);
  private final String requestChannel;
  private final String controlChannel;

  private long sequence;
  private long runId;
  private long runHeardAt;
  private boolean stopped;
  private final ArrayDeque<Job> queue = new ArrayDeque<>();
  private boolean running;
  private final Map<String, Job> partial = boundedMap(32);
  private final Map<String, Long> cancelled = boundedMap(256);
  private final Map<String, Kept> results = boundedMap(MAX_KEPT);
  private byte[] runScenario;
  private final Set<String> loaded = new HashSet<>();
  private ScenarioFetch fetch;
  private long statusDueAt = System.nanoTime();
  private long finished;
  private long repeated;
  private long refused;
  private volatile int stepsDone;
  private final ArrayBlockingQueue<Job> work = new ArrayBlockingQueue<>(1);
  private final ArrayBlockingQueue<Bowl> answers = new ArrayBlockingQueue<>(1);

  private static <V> Map<String, V> boundedMap(final int capacity) {
    return new LinkedHashMap<String, V>() {
      @Override
      protected boolean removeEldestEntry(Map.Entry<String, V> eldest) {
        return size() > capacity;
      }
    };
  }

  private JavaWorker(String url, byte[] key, String name, int stepUs) throws Exception {
    wire = new Wire(key);
    this.name = name;
    this.stepUs = stepUs;
    host = InetAddress.getLoopbackAddress().getHostName();
    long nonce = 0;
    while (nonce == 0) nonce = new SecureRandom().nextLong();
    instance = nonce;
    requestChannel = "KNAP_REQUEST_" + name;
    controlChannel = "KNAP_CONTROL_" + name;
    lcm = new LCM(url);
    for (String channel : Arrays.asList(requestChannel, controlChannel, "KNAP_SCENARIO", "KNAP_RUN_STATUS")) {
      lcm.subscribe(channel, this::receive);
    }
    Thread computing = new Thread(this::compute);
    computing.setDaemon(true);
    computing.start();
  }

  /** On LCM's thread: copies the message; when nobody takes them in time, it is lost like any other. */
  private void receive(LCM source, String channel, LCMDataInputStream in) {
    try {
      Message message = new Message();
      message.channel = channel;
      if (in.available() > Wire.MAX_MESSAGE) return;
      message.bytes = new byte[in.available()];
      in.readFully(message.bytes);
      inbox.offer(message);
    } catch (IOException e) {
      throw new IllegalStateException(e);
    }
  }

  private void compute() {
    try {
      while (true) {
        Job job = work.take();
        for (int step = 1; step <= Bowl.STEPS; ++step) {
          if (stepUs > 0) TimeUnit.MICROSECONDS.sleep(stepUs);
          stepsDone = step;
        }
        answers.put(Bowl.run(job.decided(), job.reference(), job.variation(), job.gradient));
      }
    } catch (InterruptedException e) {
      throw new IllegalStateException(e);
    }
  }

  private synchronized void loop() throws Exception {
    while (!stopped) {
      wait(1);  // lets go of the lock, so that the goodbye at SIGTERM can have it
      Message message = inbox.poll(2, TimeUnit.MILLISECONDS);
      for (; message != null; message = inbox.poll()) {
        try {
          handle(message);
        } catch (IOException e) {
          ++refused;
        }
      }
      tick();
    }
  }

  private boolean accept(byte[] bytes, long fingerprint) {
    boolean good = wire.verify(bytes, fingerprint);
    if (!good) ++refused;
    return good;
  }

  private void handle(Message message) throws IOException, GeneralSecurityException {
    byte[] bytes = message.bytes;
    if (message.channel.equals("KNAP_RUN_STATUS")) {
      // Of a run's status only the fact matters that the run speaks; run_id is the second field.
      if (accept(bytes, run_status_t.LCM_FINGERPRINT) && ByteBuffer.wrap(bytes).getLong(16) == runId) hearRun();
    } else if (message.channel.equals("KNAP_SCENARIO")) {
      if (!accept(bytes, scenario_t.LCM_FINGERPRINT)) return;
      Wire.takeCount(bytes, 52, Wire.CHUNK);
      if (fetch != null) fetch.add(new scenario_t(bytes));
    } else if (message.channel.equals(requestChannel)) {
      if (!accept(bytes, rollout_request_t.LCM_FINGERPRINT)) return;
      Wire.checkRequest(bytes);
      rollout_request_t request = new rollout_request_t(bytes);
      if (request.receiver == instance && request.run_id == runId) handleRequest(request);
    } else if (message.channel.equals(controlChannel)) {
      if (!accept(bytes, control_t.LCM_FINGERPRINT)) return;
      Wire.takeCount(bytes, 52, 32 * 32);
      Wire.takeCount(bytes, 56, 32);
      control_t control = new control_t(bytes);
      if (control.receiver == instance) handleControl(control);
    }
  }

  private void hearRun() {
    runHeardAt = System.nanoTime();
  }

  private void handleControl(control_t control) throws IOException {
    if (control.kind == control_t.kJoin) {
      join(control);
      return;
    }
    if (control.run_id != runId) return;
    hearRun();
    for (int i = 0; i + 32 <= control.ids.length; i += 32) {
      String id = Wire.hex(Arrays.copyOfRange(control.ids, i, i + 32));
      if (control.kind == control_t.kAcknowledge) acknowledge(id);
      if (control.kind == control_t.kCancel) cancel(id, control.sequence);
    }
    if (control.kind == control_t.kStop) {
      publishStatus(worker_status_t.kStopping);
      stopped = true;
    }
  }

  private void join(control_t control) {
    if (control.run_id == 0) return;
    if (control.run_id != runId) {
      if (runId != 0 && System.nanoTime() - runHeardAt < RUN_SILENCE_NS) return;
      Job current = running ? queue.peekFirst() : null;
      queue.clear();
      if (current != null) queue.add(current);
      partial.clear();
      cancelled.clear();
      for (Kept kept : results.values()) kept.acknowledged = true;
      runId = control.run_id;
      statusDueAt = System.nanoTime();
    }
    hearRun();
    runScenario = control.scenario;
  }

  private void acknowledge(String id) {
    Kept kept = results.get(id);
    if (kept != null) kept.acknowledged = true;
  }

  private void cancel(String id, long at) {
    Job current = running ? queue.peekFirst() : null;
    queue.removeIf(job -> job != current && Wire.hex(job.id).equals(id));
    partial.remove(id);
    acknowledge(id);
    cancelled.put(id, at);
  }

  private void handleRequest(rollout_request_t request) throws IOException, GeneralSecurityException {
    hearRun();
    for (int i = 0; i + 32 <= request.acknowledged.length; i += 32) {
      acknowledge(Wire.hex(Arrays.copyOfRange(request.acknowledged, i, i + 32)));
    }
    for (assignment_t assignment : request.assignments) handleAssignment(request, assignment);
  }

  private void handleAssignment(rollout_request_t request, assignment_t assignment)
      throws IOException, GeneralSecurityException {
    String id = Wire.hex(assignment.id);
    Long tombstone = cancelled.get(id);
    if (tombstone != null && request.sequence < tombstone) return;
    cancelled.remove(id);
    Kept kept = results.get(id);
    if (kept != null) {
      ++repeated;
      publishResult(kept);
      return;
    }
    for (Job job : queue) {
      if (Arrays.equals(job.id, assignment.id)) return;
    }
    if (queue.size() >= MAX_QUEUE) return;
    long total = (long) assignment.theta_size + assignment.control_size + assignment.reference_size
        + assignment.variation_size + assignment.nodes_size;
    if (total > Wire.MAX_VALUES) throw new IOException("too many values");
    Job job = partial.get(id);
    if (job == null) {
      job = new Job(request.scenario, assignment);
      partial.put(id, job);
    }
    job.add(assignment);
    if (!job.isComplete()) return;
    partial.remove(id);
    byte[] expected = Wire.calcRequestId(Bowl.NAME, job.scenario, job.theta(), job.controls(), job.reference(),
        job.variation(), job.nodes(), job.gradient);
    if (!Arrays.equals(expected, job.id)) throw new IOException("the id does not fit the request");
    queue.add(job);
  }

  private void tick() throws IOException, GeneralSecurityException {
    Bowl answer = answers.poll();
    if (answer != null) finish(answer);
    fetchScenario();
    if (!running && !queue.isEmpty() && loaded.contains(Wire.hex(queue.peekFirst().scenario))) {
      running = true;
      stepsDone = 0;
      work.add(queue.peekFirst());
    }
    long now = System.nanoTime();
    for (Kept kept : results.values()) {
      if (!kept.acknowledged && now - kept.sentAt >= RESULT_RETRY_NS) publishResult(kept);
    }
    if (now - statusDueAt >= 0) publishStatus(calcState());
  }

  private int calcState() {
    if (running) return worker_status_t.kComputing;
    return fetch != null ? worker_status_t.kLoading : worker_status_t.kIdle;
  }

  private void fetchScenario() throws IOException, GeneralSecurityException {
    byte[] wanted = queue.isEmpty() ? runScenario : queue.peekFirst().scenario;
    if (wanted == null || loaded.contains(Wire.hex(wanted))) {
      fetch = null;
      return;
    }
    if (fetch == null || !Arrays.equals(fetch.scenario, wanted)) fetch = new ScenarioFetch(wanted);
    if (fetch.isComplete()) {
      loaded.add(Wire.hex(wanted));
      fetch = null;
      return;
    }
    int[] pieces = fetch.chooseWanted();
    if (pieces.length == 0) return;
    control_t control = new control_t();
    control.utime = System.currentTimeMillis() * 1000;
    control.run_id = runId;
    control.sender = instance;
    control.sequence = ++sequence;
    control.receiver = runId;
    control.kind = control_t.kWantScenario;
    control.chunk_count = pieces.length;
    control.chunks = pieces;
    control.ids = new byte[0];
    control.scenario = wanted;
    control.worker = name;
    publish("KNAP_CONTROL", wire.seal(control));
  }

  private void finish(Bowl answer) throws IOException {
    Job job = queue.removeFirst();
    running = false;
    ++finished;
    Kept kept = new Kept();
    int first = 0;
    do {
      rollout_result_t part = new rollout_result_t();
      part.loss = answer.loss;
      part.success = answer.success ? 1 : 0;
      part.finite = part.converged = part.gradient_reliable = 1;
      part.status = rollout_result_t.kOk;
      part.steps = Bowl.STEPS;
      part.attempt = job.attempt;
      part.gradient_size = answer.gradient.length;
      part.first_value = first;
      part.value_count = Math.min(Wire.VALUES_PER_PART, answer.gradient.length - first);
      part.values = Arrays.copyOfRange(answer.gradient, first, first + part.value_count);
      part.id = job.id;
      part.worker = name;
      part.distrust = "";
      part.error = "";
      kept.parts.add(part);
      first += Wire.VALUES_PER_PART;
    } while (first < answer.gradient.length);
    results.put(Wire.hex(job.id), kept);
    publishResult(kept);
  }

  private void publishResult(Kept kept) throws IOException {
    kept.sentAt = System.nanoTime();
    for (rollout_result_t part : kept.parts) {
      part.utime = System.currentTimeMillis() * 1000;
      part.run_id = runId;
      part.sender = instance;
      part.sequence = ++sequence;
      publish("KNAP_RESULT", wire.seal(part));
    }
  }

  private void publishStatus(int state) throws IOException {
    worker_status_t status = new worker_status_t();
    status.utime = System.currentTimeMillis() * 1000;
    status.run_id = runId;
    status.sender = instance;
    status.sequence = ++sequence;
    status.steps_done = running ? stepsDone : 0;
    status.steps_total = running ? Bowl.STEPS : 0;
    status.step_fraction = running ? (double) stepsDone / Bowl.STEPS : 0.0;
    status.finished = finished;
    status.repeated = repeated;
    status.refused = refused;
    status.state = state;
    status.protocol = 5;
    status.pid = (int) ProcessHandle.current().pid();
    status.unacknowledged = (int) results.values().stream().filter(kept -> !kept.acknowledged).count();
    status.queue_capacity = MAX_QUEUE;
    ByteBuffer ids = ByteBuffer.allocate(32 * queue.size());
    for (Job job : queue) ids.put(job.id);
    status.queue = ids.array();
    status.queue_size = status.queue.length;
    if (running) status.running = queue.peekFirst().id;
    if (runScenario != null && loaded.contains(Wire.hex(runScenario))) status.scenario = runScenario;
    status.name = name;
    status.engine = Bowl.NAME;
    status.build = "";  // with no fingerprint: nothing in it may be rounded in two ways
    status.host = host;
    status.reason = "";  // it never leaves for want of anything
    publish("KNAP_WORKER_STATUS", wire.seal(status));
    statusDueAt = System.nanoTime() + STATUS_NS;
  }

  private void publish(String channel, byte[] bytes) throws IOException {
    lcm.publish(channel, bytes, 0, bytes.length);
  }

  /** SIGTERM and SIGINT: one last status, and exit code 0. */
  private synchronized void sayGoodbye() {
    try {
      if (!stopped) publishStatus(worker_status_t.kStopping);
    } catch (IOException e) {
      System.err.println("java worker: " + e.getMessage());
    }
    Runtime.getRuntime().halt(0);
  }

  public static void main(String[] arguments) throws Exception {
    byte[] key = arguments[1].isEmpty() ? "knap public key, protects nought".getBytes(StandardCharsets.US_ASCII)
                                        : Files.readAllBytes(Paths.get(arguments[1]));
    if (key.length != 32) throw new IllegalArgumentException(arguments[1] + " does not hold 32 bytes");
    JavaWorker worker = new JavaWorker(arguments[0], key, arguments[2], Integer.parseInt(arguments[3]));
    Runtime.getRuntime().addShutdownHook(new Thread(worker::sayGoodbye));
    try {
      worker.loop();
    } catch (Exception e) {
      e.printStackTrace();
      Runtime.getRuntime().halt(1);
    }
    System.exit(0);
  }
}
