// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

/**
 * Runs the common commands once, so that the JVM can store what their start needs: loaded classes
 * and profiles of methods. The launcher calls it when a release is laid out.
 */
final class Training {
    private Training() {}

    /**
     * @param worlds world files or folders
     */
    public static void main(String[] worlds) {
        Main.run("--version");
        for (String world : worlds) {
            Main.run("check", world);
            Main.run("run", world, "--seconds", "0.1");
            Main.run("serve", world, "--port", "0", "--fast", "--seconds", "0.1");
        }
        System.exit(0);
    }
}
