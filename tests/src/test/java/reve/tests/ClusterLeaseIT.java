// SPDX-License-Identifier: Apache-2.0
package reve.tests;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatExceptionOfType;

import com.typesafe.config.ConfigFactory;

import org.apache.pekko.coordination.lease.LeaseSettings;
import org.apache.pekko.coordination.lease.javadsl.Lease;
import org.junit.jupiter.api.AfterAll;
import org.junit.jupiter.api.BeforeAll;
import org.junit.jupiter.api.Test;

import reve.worlds.cluster.DatabaseLease;
import reve.worlds.journal.PostgresCatalog;
import reve.worlds.journal.PostgresStore;
import reve.worlds.journal.PostgresUrl;
import reve.worlds.journal.SqliteStore;
import reve.worlds.journal.StoreAddress;
import reve.worlds.journal.TakenStore;

import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.time.Duration;
import java.util.List;
import java.util.Map;
import java.util.Optional;
import java.util.concurrent.CompletableFuture;
import java.util.concurrent.CompletionException;

/** The lease by which one part of a divided cluster continues, and the list of its worlds. */
class ClusterLeaseIT {
    private static Postgres postgres;
    private static int databases;

    @BeforeAll
    static void start() throws Exception {
        postgres = new Postgres();
    }

    @AfterAll
    static void stop() throws Exception {
        postgres.close();
    }

    private static String database() throws Exception {
        String name = "lease" + ++databases;
        postgres.create(name);
        try (PostgresCatalog catalog = catalog(name)) {
            catalog.prepare();
        }
        return name;
    }

    private static PostgresCatalog catalog(String database) {
        return new PostgresCatalog(PostgresUrl.find(postgres.url(database)).orElseThrow());
    }

    private static Lease lease(String database, String owner) {
        return new DatabaseLease(
                LeaseSettings.apply(
                        ConfigFactory.parseMap(
                                Map.of(
                                        "store",
                                        postgres.url(database),
                                        "heartbeat-interval",
                                        "100 ms",
                                        "heartbeat-timeout",
                                        "3 s",
                                        "lease-operation-timeout",
                                        "300 ms")),
                        "lab-pekko-sbr",
                        owner));
    }

    private static boolean acquires(Lease lease) {
        return lease.acquire().toCompletableFuture().join();
    }

    @Test
    void oneOwnerHasTheLeaseUntilItReleasesIt() throws Exception {
        String database = database();
        Lease first = lease(database, "node 1");
        Lease second = lease(database, "node 2");
        assertThat(first.checkLease()).isFalse();
        assertThat(acquires(first)).isTrue();
        assertThat(first.checkLease()).isTrue();
        assertThat(acquires(second)).isFalse();
        assertThat(second.checkLease()).isFalse();
        assertThat(acquires(first)).as("the owner takes it again").isTrue();
        second.release().toCompletableFuture().join();
        assertThat(acquires(second)).as("a stranger has released nothing").isFalse();
        first.release().toCompletableFuture().join();
        assertThat(first.checkLease()).isFalse();
        assertThat(acquires(second)).isTrue();
        assertThat(acquires(lease(database, "node 2")))
                .as("another process at the address of the owner")
                .isFalse();
        second.release().toCompletableFuture().join();
    }

    /** The owner extends the lease: it is never free, although it lasts for 3 s only. */
    @Test
    void theLeaseOfAnOwnerThatIsLostEnds() throws Exception {
        String database = database();
        Lease owner = lease(database, "node 1");
        assertThat(acquires(owner)).isTrue();
        String begun = until(database);
        while (until(database).equals(begun)) {
            Thread.onSpinWait(); // until the owner extends it
        }
        try (PostgresCatalog lost = catalog(database)) {
            owner.release().toCompletableFuture().join();
            assertThat(lost.takeLease("lab-pekko-sbr", "lost", Duration.ofSeconds(1))).isTrue();
        }
        Lease next = lease(database, "node 2");
        assertThat(acquires(next)).isTrue();
        assertThat(next.checkLease()).isTrue();
        next.release().toCompletableFuture().join();
    }

    private static String until(String database) throws Exception {
        return postgres.query(database, "SELECT lease_until FROM reve.lease").getFirst();
    }

    @Test
    void anOwnerLearnsThatItHasLostTheLease() throws Exception {
        String database = database();
        CompletableFuture<Optional<Throwable>> loss = new CompletableFuture<>();
        Lease owner = lease(database, "node 1");
        assertThat(owner.acquire(loss::complete).toCompletableFuture().join()).isTrue();
        postgres.execute(database, "UPDATE reve.lease SET owner = 'another'");
        assertThat(loss.join()).isEmpty();
        assertThat(owner.checkLease()).isFalse();
    }

    @Test
    void withoutTheDatabaseNobodyHasTheLease() throws Exception {
        String database = database();
        CompletableFuture<Optional<Throwable>> loss = new CompletableFuture<>();
        Lease owner = lease(database, "node 1");
        assertThat(owner.acquire(loss::complete).toCompletableFuture().join()).isTrue();
        postgres.stop();
        try {
            assertThat(loss.join()).get().isInstanceOf(IOException.class);
            assertThat(owner.checkLease()).isFalse();
            assertThatExceptionOfType(CompletionException.class)
                    .isThrownBy(() -> acquires(lease(database, "node 2")))
                    .withMessageContaining(postgres.url(database));
        } finally {
            postgres.start();
        }
        Lease next = lease(database, "node 2");
        assertThat(acquires(next)).as("the lease of the first owner has ended").isTrue();
        next.release().toCompletableFuture().join();
    }

    @Test
    void aWorldIsAddedOnceAndMadeNoFrames() throws Exception {
        String database = database();
        Path pack = Files.createTempFile("reve-test-", ".zip");
        try (PostgresCatalog catalog = catalog(database)) {
            Files.writeString(pack, "the first pack");
            assertThat(catalog.add("w", pack)).isTrue();
            Files.writeString(pack, "another pack");
            assertThat(catalog.add("w", pack)).isFalse();
            assertThat(catalog.worlds())
                    .singleElement()
                    .satisfies(
                            world -> {
                                assertThat(world.name()).isEqualTo("w");
                                assertThat(world.epoch()).isZero();
                                assertThat(world.isOwned()).isFalse();
                                assertThat(world.frame()).isEqualTo(-1);
                            });
            PostgresUrl url = PostgresUrl.find(postgres.url(database)).orElseThrow();
            assertThat(PostgresStore.pack(url, "w"))
                    .hasValueSatisfying(
                            bytes -> assertThat(new String(bytes)).isEqualTo("the first pack"));
            try (TakenStore taken =
                    new StoreAddress.InDatabase(url, "w", Optional.empty())
                            .take(SqliteStore.Durability.NORMAL, _ -> {})) {
                assertThat(taken.epoch()).hasValue(1);
                assertThat(taken.contents().isEmpty()).isTrue();
                assertThat(catalog.worlds())
                        .extracting(PostgresStore.World::isOwned)
                        .isEqualTo(List.of(true));
            }
        } finally {
            Files.delete(pack);
        }
    }
}
