// SPDX-License-Identifier: Apache-2.0
package reve.pe.adapter;

import reve.core.world.ItemDefinition;
import reve.core.world.WorldPrototype;
import reve.pe.NativeFiles;
import reve.pe.hosted.ApartRule;
import reve.pe.hosted.HostedEngine;
import reve.pe.hosted.Hosts;
import reve.pe.vesper.VesperConfig;
import reve.pe.vesper.VesperEngine;

import java.nio.file.Path;
import java.time.Duration;
import java.util.ArrayList;
import java.util.List;
import java.util.concurrent.CopyOnWriteArrayList;

/**
 * A world of bodies and scenery whose engine runs in a process of its own, and an equal world whose
 * engine runs in this process.
 */
final class HostedFixture implements AutoCloseable {
    static final Duration FRAME_LIMIT = Duration.ofMillis(300);
    private static final long MEMORY_BYTES = 1L << 28;
    private static final int BODIES = 20;

    final Hosts hosts;
    final List<String> log = new CopyOnWriteArrayList<>();
    final AdapterFixture world;

    HostedFixture() {
        this(1);
    }

    HostedFixture(int threads) {
        this(threads, NativeFiles.program("vesper-host"));
    }

    HostedFixture(int threads, Path program) {
        this(threads, program, ApartRule.NEVER);
    }

    HostedFixture(int threads, Path program, ApartRule apart) {
        hosts = new Hosts(program, MEMORY_BYTES);
        SharedArena arena = new SharedArena();
        world =
                new AdapterFixture(
                        WorldPrototype.standard("si-f64"),
                        items(),
                        arena,
                        false,
                        engine -> {
                            engine.close();
                            return new HostedEngine(
                                    hosts,
                                    FRAME_LIMIT,
                                    new VesperConfig(
                                            threads,
                                            false,
                                            NativeFiles.lawPath(),
                                            (level, message) -> log.add(level + " " + message)),
                                    PropertyNames.prototype(
                                            WorldPrototype.standard("si-f64"),
                                            VesperEngine.standardPrototype("si-f64")),
                                    apart,
                                    arena::part);
                        });
    }

    /** The same world with its engine in this process. */
    static AdapterFixture inProcess() {
        return new AdapterFixture(
                WorldPrototype.standard("si-f64"),
                items(),
                new SharedArena(),
                false,
                engine -> engine);
    }

    private static List<ItemDefinition> items() {
        List<ItemDefinition> items = new ArrayList<>();
        for (int i = 0; i < BODIES; i++) {
            items.add(AdapterFixture.body("b" + i, 1 + i, i, 2 * i, 0, 0.1 * i, 0, 1));
        }
        items.add(ItemDefinition.named("tree").at(100, 0, 0).build());
        return items;
    }

    @Override
    public void close() {
        world.close();
        hosts.close();
    }
}
