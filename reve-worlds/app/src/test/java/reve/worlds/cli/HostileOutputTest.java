// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import static org.assertj.core.api.Assertions.assertThat;
import static org.assertj.core.api.Assertions.assertThatThrownBy;

import ch.qos.logback.classic.Level;
import ch.qos.logback.classic.LoggerContext;
import ch.qos.logback.classic.joran.JoranConfigurator;
import ch.qos.logback.classic.spi.ILoggingEvent;
import ch.qos.logback.classic.spi.LoggingEvent;
import ch.qos.logback.core.AsyncAppenderBase;
import ch.qos.logback.core.ConsoleAppender;
import ch.qos.logback.core.encoder.Encoder;

import org.junit.jupiter.api.Test;

import reve.core.file.WorldFile;
import reve.core.file.WorldFileException;
import reve.pe.PhysicsException;
import reve.pe.Status;

import tools.jackson.databind.json.JsonMapper;

import java.io.ByteArrayOutputStream;
import java.io.IOException;
import java.io.PrintStream;
import java.io.PrintWriter;
import java.io.StringWriter;
import java.io.Writer;
import java.nio.charset.StandardCharsets;
import java.nio.file.NoSuchFileException;
import java.util.ArrayList;
import java.util.List;
import java.util.Map;
import java.util.Random;

/** Foreign text in output for people, which is events, results and log lines. */
class HostileOutputTest {
    private static final int TEXTS = 100_000;
    private static final int LOGGED = 10_000;
    private static final List<String> PIECES =
            List.of(
                    "\n",
                    "\r\n",
                    "\rfault source=world ",
                    "\nfault source=world message=gone\n",
                    "\u001b[2J",
                    "\u001b]0;title\u0007",
                    "\0",
                    "\b",
                    "\u007f",
                    "\u0085",
                    "\u009b31m",
                    "\u2028",
                    "\u2029",
                    "\u202e",
                    "\u2066",
                    "\u200b",
                    "\ufeff",
                    "\ud83e",
                    "\udd86",
                    "\udb40\udc41",
                    "\ue000",
                    "\t",
                    "%s",
                    "{}",
                    "\\",
                    "\"",
                    " ERROR reve.world -- ",
                    "ada",
                    "Ö",
                    "名前",
                    "می\u200cخواهم",
                    "\ud83e\udd86");

    private final Random random = new Random(16);

    private String text() {
        var text = new StringBuilder();
        for (int i = random.nextInt(1, 8); i > 0; i--) {
            if (random.nextInt(4) == 0) {
                text.append((char) random.nextInt(1 << 16));
            } else {
                text.append(PIECES.get(random.nextInt(PIECES.size())));
            }
        }
        return text.toString();
    }

    private List<String> texts(int count) {
        List<String> texts = new ArrayList<>();
        for (int i = 0; i < count; i++) {
            texts.add(text());
        }
        return texts;
    }

    /**
     * @return the lines, in each of which all content is visible
     */
    private static List<String> lines(String output) {
        assertThat(output).endsWith("\n");
        List<String> lines = List.of(output.substring(0, output.length() - 1).split("\n", -1));
        for (String line : lines) {
            boolean safe =
                    line.codePoints()
                            .allMatch(
                                    c ->
                                            switch (Character.getType(c)) {
                                                case Character.CONTROL,
                                                        Character.SURROGATE,
                                                        Character.LINE_SEPARATOR,
                                                        Character.PARAGRAPH_SEPARATOR,
                                                        Character.PRIVATE_USE ->
                                                        false;
                                                case Character.FORMAT -> c == 0x200c || c == 0x200d;
                                                default -> true;
                                            });
            if (!safe) {
                throw new AssertionError("unsafe: " + line);
            }
        }
        return lines;
    }

    private static List<String> printed(boolean json, List<String> texts) {
        var out = new StringWriter();
        for (int from = 0; from < texts.size(); from += 5000) {
            try (var printer =
                    new EventPrinter(
                            new LinePrinter(out),
                            new PrintWriter(Writer.nullWriter()),
                            json,
                            Printed.ACTIONS)) {
                texts.subList(from, Math.min(texts.size(), from + 5000))
                        .forEach(text -> printer.happened("rewound", Map.of("image", text)));
            }
        }
        return lines(out.toString());
    }

    /** The name of a world file is foreign text, too. */
    @Test
    void theNoticeOfLongWorkIsOneLine() throws Exception {
        var bytes = new ByteArrayOutputStream();
        try (var out = new PrintStream(bytes, true, StandardCharsets.UTF_8);
                var _ = new Patience(out, "reading a\n2026 WARN  agents: forged\u001b[31m.yaml")) {
            while (bytes.size() == 0) {
                Thread.sleep(20);
            }
        }
        assertThat(bytes.toString(StandardCharsets.UTF_8))
                .isEqualTo("reading a\\u{a}2026 WARN  agents: forged\\u{1b}[31m.yaml ...\n");
    }

    @Test
    void anEventIsOneLineWithoutControlCharactersWhateverTextIsInIt() {
        List<String> lines = printed(false, texts(TEXTS));
        assertThat(lines).hasSize(TEXTS).allMatch(line -> line.startsWith("rewound image="));
    }

    @Test
    void anEventAsJsonHasNoControlCharactersAndSaysTheSame() {
        List<String> texts = texts(TEXTS);
        List<String> lines = printed(true, texts);
        var mapper = new JsonMapper();
        for (int i = 0; i < TEXTS; i++) {
            String image = mapper.readTree(lines.get(i)).get("image").stringValue();
            if (!image.equals(texts.get(i))) {
                assertThat(image).isEqualTo(texts.get(i));
            }
        }
        assertThat(lines).hasSize(TEXTS);
    }

    @Test
    void aPrintedLineIsOneLineAndHonestTextStaysAsItIs() {
        var text = new StringWriter();
        var out = new LinePrinter(text);
        String honest = "Öl, 名前, می\u200cخواهم, עברית, \ud83e\udd86 \u00a7 ½ \\ %";
        out.println(honest);
        out.println((Object) "a\nb");
        out.printf("%s: %d of %.1f%n", "a\u001b[31m\r\nb", 3, 0.5);
        LinePrinter.message(out, List.of("first", "second", "third\u2028\nfault"));
        assertThat(text.toString().lines())
                .containsExactly(
                        honest,
                        "a\\u{a}b",
                        "a\\u{1b}[31m\\u{d}\\u{a}b: 3 of 0.5",
                        "first",
                        "  second",
                        "  third\\u{2028}\\u{a}fault");
    }

    @Test
    void onlyAnEnumerationOfProblemsHasSeveralLines() {
        String name = "evil\nfault: forged";
        assertThat(Main.lines(new NoSuchFileException(name))).containsExactly("reve: " + name);
        assertThat(Main.lines(new IOException(name))).containsExactly("reve: " + name);
        assertThat(Main.lines(new PhysicsException(Status.NOT_FOUND, "a: no\nb: no")))
                .containsExactly("reve: a: no", "b: no");
        assertThatThrownBy(
                        () ->
                                WorldFile.parse(
                                        "evil\nworld.yaml",
                                        "reve: 1\nname: x\n\"z\\nfault\": 1\n"
                                                .getBytes(StandardCharsets.UTF_8)))
                .isInstanceOfSatisfying(
                        WorldFileException.class,
                        invalid ->
                                assertThat(Main.lines(invalid))
                                        .hasSameSizeAs(invalid.problems())
                                        .first()
                                        .asString()
                                        .startsWith("reve: evil\nworld.yaml:"));
    }

    @Test
    void aLogLineIsOneLineWithItsDateWhateverTextIsInIt() throws Exception {
        var context = new LoggerContext();
        var configurator = new JoranConfigurator();
        configurator.setContext(context);
        configurator.doConfigure(LogText.class.getResource("/logback.xml"));
        var logger = context.getLogger("reve.agents");
        var async = (AsyncAppenderBase<?>) context.getLogger("ROOT").getAppender("ASYNC");
        Encoder<ILoggingEvent> encoder = encoder(async);
        try {
            for (String text : texts(LOGGED)) {
                Throwable thrown =
                        random.nextInt(4) > 0
                                ? null
                                : new IllegalStateException(text, new Exception(text));
                var event =
                        new LoggingEvent(
                                "here", logger, Level.WARN, "{} left", thrown, new Object[] {text});
                String line = new String(encoder.encode(event), StandardCharsets.UTF_8);
                assertThat(lines(line)).hasSize(1);
                assertThat(line)
                        .matches(
                                "(?s)20\\d\\d-\\d\\d-\\d\\dT\\d\\d:\\d\\d:\\d\\d\\.\\d{3}"
                                        + "(Z|[+-]\\d\\d:\\d\\d) WARN  agents: .*")
                        .contains(thrown == null ? "" : "caused by java.lang.Exception");
            }
        } finally {
            context.stop();
        }
    }

    @SuppressWarnings("unchecked")
    private static Encoder<ILoggingEvent> encoder(AsyncAppenderBase<?> async) {
        return ((ConsoleAppender<ILoggingEvent>) async.getAppender("STDERR")).getEncoder();
    }
}
