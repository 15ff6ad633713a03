// SPDX-License-Identifier: Apache-2.0
package reve.core.agent.net;

import static org.assertj.core.api.Assertions.assertThat;

import org.junit.jupiter.api.Test;
import org.slf4j.Logger;

import java.lang.reflect.Proxy;
import java.util.List;
import java.util.concurrent.CopyOnWriteArrayList;
import java.util.concurrent.CountDownLatch;
import java.util.concurrent.TimeUnit;
import java.util.concurrent.locks.LockSupport;

/** The event loop goes on after failures of its tasks. */
class EventLoopTest {

    /** The files of a running program were overwritten, so that no further class can be loaded. */
    @Test
    void aTaskThatFailsWhileTheLogFailsStopsNothing() throws Exception {
        Logger lost =
                (Logger)
                        Proxy.newProxyInstance(
                                Logger.class.getClassLoader(),
                                new Class<?>[] {Logger.class},
                                (proxy, method, arguments) -> {
                                    throw new NoClassDefFoundError("of the log");
                                });
        EventLoop.Work nothing =
                new EventLoop.Work() {
                    @Override
                    public boolean isWaiting() {
                        return false;
                    }

                    @Override
                    public void run() {}

                    @Override
                    public void checkDeadlines(long nowNanos) {}
                };
        var loop = new EventLoop(new RateLimitedLog(lost, 10, "agents"), nothing, 1_000_000);
        loop.start();
        for (int i = 0; i < 3; i++) {
            var done = new CountDownLatch(1);
            loop.later(
                    () -> {
                        throw new NoClassDefFoundError("of a command");
                    });
            loop.later(done::countDown);
            assertThat(done.await(300, TimeUnit.SECONDS)).isTrue();
        }
        loop.stop();
        assertThat(loop.join(300_000)).isTrue();
    }

    /** A client that sent something during the pause of the server is not late. */
    @Test
    void afterAPauseTheLoopReadsBeforeItChecksDeadlines() throws Exception {
        List<String> order = new CopyOnWriteArrayList<>();
        var checked = new CountDownLatch(1);
        EventLoop.Work work =
                new EventLoop.Work() {
                    @Override
                    public boolean isWaiting() {
                        return false;
                    }

                    @Override
                    public void run() {}

                    @Override
                    public void checkDeadlines(long nowNanos) {
                        if (order.contains("paused")) {
                            order.add("checked");
                            checked.countDown();
                        }
                    }
                };
        var loop = new EventLoop(new RateLimitedLog(10, "agents"), work, 20_000_000);
        loop.start();
        loop.later(
                () -> {
                    LockSupport.parkNanos(200_000_000); // ten times the time between two checks
                    order.add("paused");
                    loop.later(() -> order.add("next turn"));
                });
        assertThat(checked.await(300, TimeUnit.SECONDS)).isTrue();
        loop.stop();
        assertThat(loop.join(300_000)).isTrue();
        assertThat(order).startsWith("paused", "next turn", "checked");
    }
}
