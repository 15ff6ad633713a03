// SPDX-License-Identifier: Apache-2.0
package reve.worlds.web;

import org.eclipse.jetty.server.Handler;
import org.eclipse.jetty.server.Request;
import org.eclipse.jetty.server.Response;
import org.eclipse.jetty.util.Callback;

/** Makes an HTTP request wait if its connection has sent too many requests. */
final class Turns extends Handler.Wrapper {

    @Override
    public boolean handle(Request request, Response response, Callback callback) throws Exception {
        MeteredEndPoint.budgetOf(request).takeRequest();
        return super.handle(request, response, callback);
    }
}
