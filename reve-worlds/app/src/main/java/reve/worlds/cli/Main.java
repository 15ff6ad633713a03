// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine;
import picocli.CommandLine.Command;
import picocli.CommandLine.IVersionProvider;
import picocli.CommandLine.Model.UsageMessageSpec;
import picocli.CommandLine.ParameterException;
import picocli.CommandLine.ScopeType;
import picocli.CommandLine.TypeConversionException;

import reve.core.file.Problem;
import reve.core.file.WorldFileException;
import reve.core.plugin.PluginException;
import reve.pe.PhysicsException;
import reve.worlds.Product;
import reve.worlds.journal.PostgresUrl;

import java.io.FileDescriptor;
import java.io.FileOutputStream;
import java.io.OutputStream;
import java.io.PrintWriter;
import java.net.BindException;
import java.nio.file.AccessDeniedException;
import java.nio.file.InvalidPathException;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import java.util.Optional;
import java.util.stream.Stream;

/**
 * The {@code ./reve} command line. It parses the arguments, runs a command, and converts failures
 * to exit codes.
 */
@Command(
        name = "./reve",
        description =
                "Virtual worlds whose laws of nature can be added, replaced and removed "
                        + "while they run.",
        mixinStandardHelpOptions = true,
        versionProvider = Main.Version.class,
        scope = ScopeType.INHERIT,
        footer = {
            "",
            "Exit codes: 0 done, 1 failed, 2 wrong usage, 3 invalid world file,",
            "4 a law or the native engine could not be loaded, 5 the port could not be bound,",
            "or the address requires tokens and TLS, 6 a world stalled (serve --stalled exit),",
            "137 out of memory, 141 the reader of standard output has closed it.",
        })
public final class Main {

    /** The commands, in the order of the help. */
    private static final List<Class<?>> COMMANDS =
            List.of(
                    ServeCommand.class,
                    RunCommand.class,
                    ExperimentCommand.class,
                    ReplayCommand.class,
                    PictureCommand.class,
                    VideoCommand.class,
                    ExportCommand.class,
                    CheckCommand.class,
                    LawCommand.class,
                    DemoCommand.class,
                    ControlCommand.class,
                    TokenCommand.class,
                    StoreCommand.class,
                    ClusterCommand.class,
                    NewCommand.class,
                    PackCommand.class,
                    ImportCommand.class,
                    CommandLine.HelpCommand.class);

    private static final String DOCTOR =
            "  doctor     Says which shared libraries of the system are missing.";

    /** The commands that the launcher script of a checkout runs without Java. */
    private static final List<String> LAUNCHER =
            List.of(
                    "",
                    "Commands of the launcher script:",
                    "  build      Builds what changed and stops.",
                    "  test       Builds, then runs the tests of the project, or of rooms of it.",
                    "  format     Formats the sources, or checks that they are formatted.",
                    "  docs       Writes the pages of the Java, C and C++ API.",
                    "  install    Makes a folder that runs without this checkout.",
                    "  clean      Removes everything that was built.",
                    DOCTOR);

    /** The commands that the launcher script of an installed release runs without Java. */
    private static final List<String> INSTALLED =
            List.of("", "Commands of the launcher script:", DOCTOR);

    /** The command that prints the description of another command. */
    private static final String HELP = "help";

    /** The options that print the version. */
    private static final List<String> VERSION = List.of("-V", "--version");

    private Main() {}

    /** Runs one command and ends the process with its exit code. */
    public static void main(String[] arguments) {
        Thread.setDefaultUncaughtExceptionHandler(Main::reportEnd);
        System.exit(run(new FileOutputStream(FileDescriptor.out), arguments));
    }

    /**
     * Reports a thread that ended because of an exception. The JVM's own report would print foreign
     * text, such as file names, unescaped. Ends the process if a class could not be loaded, because
     * the program's files have then changed: a server would keep its connections without an answer.
     */
    static void reportEnd(Thread thread, Throwable failure) {
        if (failure instanceof LinkageError) {
            // This code must load no class of the program.
            System.err.println(
                    "reve: the process ends, because the program's files have changed while it ran ("
                            + failure.getClass().getSimpleName()
                            + "); install a new version into a new folder");
            Runtime.getRuntime().halt(ExitCode.FAILURE);
        }
        LinePrinter err = new LinePrinter(System.err);
        List<String> lines = new ArrayList<>();
        lines.add("reve: the thread '" + thread.getName() + "' ended: " + failure);
        for (StackTraceElement call : failure.getStackTrace()) {
            lines.add("at " + call);
        }
        LinePrinter.message(err, lines);
        err.flush();
    }

    /** Runs one command line and returns its exit code; for tests. */
    public static int run(String... arguments) {
        return run(System.out, arguments);
    }

    private static int run(OutputStream stream, String... arguments) {
        CommandLine line = new CommandLine(new Main());
        commandsFor(arguments).forEach(line::addSubcommand);
        String name = Product.command();
        line.setCommandName(name);
        LinePrinter out = new LinePrinter(stream);
        line.setOut(out);
        line.setErr(new LinePrinter(System.err));
        UsageMessageSpec usage = line.getCommandSpec().usageMessage();
        List<String> launcher = name.equals(Product.CHECKOUT_COMMAND) ? LAUNCHER : INSTALLED;
        usage.footer(
                Stream.concat(launcher.stream(), Stream.of(usage.footer())).toArray(String[]::new));
        line.registerConverter(Path.class, Main::path);
        line.registerConverter(StoreArgument.class, Main::store);
        NumberArguments.register(line);
        line.setParameterExceptionHandler(Main::explainUsage);
        line.setExecutionExceptionHandler(Main::explain);
        line.setCaseInsensitiveEnumValuesAllowed(true);
        line.setExpandAtFiles(false); // the name of a world's folder may begin with @
        if (arguments.length == 0) {
            line.usage(System.err);
            return ExitCode.USAGE;
        }
        ClassLoader loader = Thread.currentThread().getContextClassLoader();
        try {
            return out.codeAfter(line.execute(arguments), line.getErr());
        } finally {
            LawOptions.endWaiting();
            PluginOptions.endUse(loader);
        }
    }

    /**
     * Returns the commands that must be described to the parser. Usually this is only the command
     * that the first argument names, and for {@code --version} there is none. Any other argument
     * needs all commands, for help and suggestions. Describing takes longer than most commands run,
     * so it is limited to the necessary commands.
     */
    private static List<Class<?>> commandsFor(String... arguments) {
        if (arguments.length > 0 && VERSION.contains(arguments[0])) {
            return List.of();
        }
        for (Class<?> command : COMMANDS) {
            String name = command.getAnnotation(Command.class).name();
            if (arguments.length > 0 && name.equals(arguments[0]) && !name.equals(HELP)) {
                return List.of(command);
            }
        }
        return COMMANDS;
    }

    /**
     * Converts an option's text to a path. Refuses an empty text, because it would mean the current
     * folder. An unset shell variable produces such a text.
     */
    private static Path path(String given) {
        if (given.isEmpty()) {
            throw new TypeConversionException("expected a file or a folder, found nothing");
        }
        try {
            return Path.of(given);
        } catch (InvalidPathException e) {
            throw new TypeConversionException(
                    "the character set of the system cannot write this name (LC_ALL or LANG);"
                            + " expected UTF-8, for example LC_ALL=C.UTF-8");
        }
    }

    /** Converts an option's text to the name of a store. */
    private static StoreArgument store(String given) {
        try {
            Optional<PostgresUrl> url = PostgresUrl.find(given);
            return new StoreArgument(
                    given, url, url.isPresent() ? Optional.empty() : Optional.of(path(given)));
        } catch (IllegalArgumentException e) {
            throw new TypeConversionException(e.getMessage());
        }
    }

    /**
     * Prints the usage error and names the command that prints the full help. The help itself is
     * not printed here, because its length would hide the error.
     */
    private static int explainUsage(ParameterException wrong, String... arguments) {
        CommandLine line = wrong.getCommandLine();
        PrintWriter err = line.getErr();
        err.println("reve: " + UsageMessage.of(wrong));
        err.println("`" + line.getCommandSpec().qualifiedName() + " --help` says more");
        err.flush();
        return ExitCode.USAGE;
    }

    /** Prints one message without a stack trace. The message states what the user can do. */
    private static int explain(
            Exception failure, CommandLine line, CommandLine.ParseResult parsed) {
        PrintWriter err = line.getErr();
        int code = ExitCode.of(failure);
        LinePrinter.message(err, lines(failure));
        if (code == ExitCode.FAILURE
                && !(failure instanceof PhysicsException)
                && Boolean.getBoolean("reve.debug")) {
            failure.printStackTrace(err);
        }
        err.flush();
        return code;
    }

    /**
     * Returns the lines of a failure's message. Only the exceptions listed here have messages of
     * several lines. A line end in other messages is part of a name, such as a file name, and the
     * printer escapes it.
     */
    static List<String> lines(Exception failure) {
        List<String> lines =
                switch (failure) {
                    case WorldFileException invalid ->
                            invalid.problems().stream().map(Problem::toString).toList();
                    case PluginException refused -> refused.problems();
                    case PhysicsException refused -> message(refused).lines().toList();
                    case BindException refused -> message(refused).lines().toList();
                    default -> List.of(message(failure));
                };
        return Stream.concat(
                        Stream.of("reve: " + (lines.isEmpty() ? "" : lines.getFirst())),
                        lines.stream().skip(1))
                .toList();
    }

    private static String message(Exception failure) {
        if (failure instanceof AccessDeniedException denied && denied.getReason() == null) {
            return denied.getFile() + ": permission denied";
        }
        return failure.getMessage() == null ? failure.toString() : failure.getMessage();
    }

    /**
     * Provider of the text for {@code --version}: the versions of the product, the Java runtime and
     * the operating system.
     */
    static final class Version implements IVersionProvider {
        @Override
        public String[] getVersion() {
            return new String[] {
                "REVE x Vesper " + Product.version(), "Java ${java.version}, ${os.name} ${os.arch}",
            };
        }
    }
}
