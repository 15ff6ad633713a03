// SPDX-License-Identifier: Apache-2.0
package reve.worlds.cli;

import picocli.CommandLine.ITypeConverter;
import picocli.CommandLine.TypeConversionException;

import reve.worlds.render.ImageFormat;

import java.util.regex.Matcher;
import java.util.regex.Pattern;

/** Converts a text such as {@code 960x640} to a picture format. */
final class SizeConverter implements ITypeConverter<ImageFormat> {
    private static final Pattern SIZE = Pattern.compile("(\\d{1,5})x(\\d{1,5})");

    @Override
    public ImageFormat convert(String value) {
        Matcher size = SIZE.matcher(value);
        if (!size.matches()) {
            throw new TypeConversionException("'" + value + "' is no size, expected e.g. 960x640");
        }
        try {
            return ImageFormat.of(Integer.parseInt(size.group(1)), Integer.parseInt(size.group(2)));
        } catch (IllegalArgumentException tooLarge) {
            throw new TypeConversionException(tooLarge.getMessage());
        }
    }
}
